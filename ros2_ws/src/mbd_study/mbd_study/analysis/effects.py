"""How large a difference is: in the measure's own unit, and in units that compare across measures.

References:
    Hedges, L. V. (1981): Distribution theory for Glass's estimator of effect size. J. Educational
        Statistics 6, 107-128.
    Lakens, D. (2013): Calculating and reporting effect sizes. Frontiers in Psychology 4:863.
    Kerby, D. S. (2014): The simple difference formula. Comprehensive Psychology 3:11.
    Newcombe, R. G. (1998): Interval estimation for the difference between independent proportions. Statistics in
        Medicine 17, 873-890 (method 10); of paired ones: 2635-2650 (method 10).
"""

from __future__ import annotations

import numpy as np
from scipy import special, stats

from mbd_study.analysis.describing import wilson_interval
from mbd_study.analysis.exact_tests import paired_differences


def hedges_correction(degrees: float) -> float:
    """What Cohen's d is multiplied by to be unbiased.

    Args:
        degrees: of freedom, at least 2.
    """
    return float(np.exp(special.gammaln(degrees / 2) - special.gammaln((degrees - 1) / 2)) / np.sqrt(degrees / 2))


def hedges_g(one: np.ndarray, other: np.ndarray) -> float | None:
    """The difference of two groups by their pooled standard deviation; None where there is none.

    Args:
        one: (n,).
        other: (m,).
    """
    degrees = len(one) + len(other) - 2
    if min(len(one), len(other)) < 2 or degrees < 2:
        return None
    pooled = np.sqrt(((len(one) - 1) * one.var(ddof=1) + (len(other) - 1) * other.var(ddof=1)) / degrees)
    return float((one.mean() - other.mean()) / pooled) * hedges_correction(degrees) if pooled > 0 else None


def hedges_g_av(one: np.ndarray, other: np.ndarray) -> float | None:
    """The mean difference of pairs by the average standard deviation of both, which compares with `hedges_g`.

    Args:
        one: (n,).
        other: of the same participants, (n,).
    """
    if len(one) < 3:
        return None
    spread = np.sqrt((one.var(ddof=1) + other.var(ddof=1)) / 2)
    return float((one - other).mean() / spread) * hedges_correction(len(one) - 1) if spread > 0 else None


def cohens_d_z(one: np.ndarray, other: np.ndarray) -> float | None:
    """The mean difference of pairs by the standard deviation of the differences, on which a test's power rests.

    Args:
        one: (n,).
        other: of the same participants, (n,).
    """
    differences = one - other
    spread = differences.std(ddof=1) if len(differences) > 1 else 0.0
    return float(differences.mean() / spread) if spread > 0 else None


def rank_biserial(one: np.ndarray, other: np.ndarray, *, paired: bool) -> float | None:
    """Favourable minus unfavourable share [-1..1]: of the ranks of pairs' differences, or of all pairs of two groups.

    Args:
        one: (n,).
        other: of the same participants where paired.
        paired: which of both.
    """
    if not paired:
        return float(np.sign(one[:, None] - other[None]).mean())
    differences = paired_differences(one, other)
    differences = differences[differences != 0]
    if not len(differences):
        return None
    ranks = stats.rankdata(np.abs(differences))
    return float((np.sign(differences) * ranks).sum() / ranks.sum())


def kendalls_w(table: np.ndarray) -> float:
    """Agreement of the participants about the order of the conditions [0..1], ties taken into account.

    Args:
        table: (participants, conditions), without gaps.
    """
    people, width = table.shape
    ranks = np.array([stats.rankdata(row) for row in table])
    spread = (ranks**2).sum() - people * width * (width + 1) ** 2 / 4
    off = ((ranks.sum(axis=0) - people * (width + 1) / 2) ** 2).sum()
    return float(off / (people * spread)) if spread > 0 else 0.0


def mean_difference(one: np.ndarray, other: np.ndarray, *, paired: bool) -> tuple[float, float | None, float | None]:
    """The difference of means with its 95 % interval, by t (Welch's for groups).

    Args:
        one: (n,).
        other: of the same participants where paired.
        paired: which of both.
    """
    value = float(one.mean() - other.mean())
    if min(len(one), len(other)) < 2:
        return value, None, None
    if paired:
        error, degrees = float((one - other).std(ddof=1) / np.sqrt(len(one))), float(len(one) - 1)
    else:
        parts = one.var(ddof=1) / len(one), other.var(ddof=1) / len(other)
        error = float(np.sqrt(sum(parts)))
        below = parts[0] ** 2 / (len(one) - 1) + parts[1] ** 2 / (len(other) - 1)
        degrees = float(sum(parts) ** 2 / below) if below > 0 else float(len(one) + len(other) - 2)
    half = float(stats.t.ppf(0.975, degrees)) * error
    return value, value - half, value + half


def share_difference(one: np.ndarray, other: np.ndarray, *, paired: bool) -> tuple[float, float, float]:
    """The difference of two shares of yes with Newcombe's 95 % interval.

    Args:
        one: 0 or 1, (n,).
        other: of the same participants where paired.
        paired: which of both.
    """
    p, q = float(one.mean()), float(other.mean())
    (l1, u1), (l2, u2) = (wilson_interval(int(x.sum()), len(x)) for x in (one, other))
    phi = 0.0
    if paired:
        a, d = float(((one == 1) & (other == 1)).sum()), float(((one == 0) & (other == 0)).sum())
        b, c = float(((one == 1) & (other == 0)).sum()), float(((one == 0) & (other == 1)).sum())
        product = (a + b) * (c + d) * (a + c) * (b + d)
        top = a * d - b * c
        # Of a positive association half the participants are taken off, as Newcombe does.
        top = max(top - len(one) / 2, 0.0) if top > 0 else top
        phi = top / np.sqrt(product) if product > 0 else 0.0
    low = np.sqrt(max((p - l1) ** 2 - 2 * phi * (p - l1) * (u2 - q) + (u2 - q) ** 2, 0.0))
    high = np.sqrt(max((u1 - p) ** 2 - 2 * phi * (u1 - p) * (q - l2) + (q - l2) ** 2, 0.0))
    return p - q, p - q - float(low), p - q + float(high)
