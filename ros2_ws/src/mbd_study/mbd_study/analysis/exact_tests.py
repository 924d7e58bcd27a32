"""Tests by ranks and counts that are exact for few participants, ties and zeros included."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from math import factorial

import numpy as np
from scipy import stats

# More arrangements than this are drawn by chance instead of listed; of more values the normal approximation is taken.
MOST = 200_000
MOST_PAIRS, MOST_IN_GROUPS = 300, 80
DRAWN = 100_000
SEED = 20170306


@dataclass(frozen=True)
class TestFigures:
    """A test's result.

    Attributes:
        test: its name.
        statistic: as it is written, "W = 12" say.
        p: two-sided.
        exact: by all arrangements, not by an approximation.
    """

    __test__ = False  # pytest takes it for a test

    test: str
    statistic: str
    p: float
    exact: bool


def paired_differences(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """One minus the other, equal differences of decimal numbers equal: 1.9 - 0.7 and 2.9 - 1.7 are a tie.

    Args:
        one: (n,).
        other: of the same participants, (n,).
    """
    unit = max(float(np.abs(one).max(initial=0)), float(np.abs(other).max(initial=0))) * 1e-11
    return np.asarray(np.round((one - other) / unit) * unit if unit > 0 else one - other)


def signed_rank(one: np.ndarray, other: np.ndarray) -> TestFigures:
    """Wilcoxon's signed-rank test of pairs: the p of all 2^n signs up to n = 300, else by normal approximation.

    Args:
        one: (n,).
        other: of the same participants, (n,).
    """
    differences = paired_differences(one, other)
    differences = differences[differences != 0]
    count = len(differences)
    name = "Wilcoxon signed-rank"
    if count == 0:
        return TestFigures(name, "W = 0", 1.0, True)
    ranks = stats.rankdata(np.abs(differences))
    positive = float(ranks[differences > 0].sum())
    words = f"W = {positive:g}, n = {count} without ties"
    if count > MOST_PAIRS:
        return TestFigures(name, words, float(stats.wilcoxon(differences, method="approx").pvalue), False)
    # How probable each sum of ranks is, rank by rank (twice the ranks are whole numbers).
    doubled = np.rint(2 * ranks).astype(int)
    share = np.zeros(int(doubled.sum()) + 1)
    share[0] = 1.0
    for rank in doubled:
        share[rank:] += share[:-rank].copy()
        share /= 2
    sums = np.arange(len(share)) / 2
    middle = ranks.sum() / 2
    p = float(share[np.abs(sums - middle) >= abs(positive - middle) - 1e-9].sum())
    return TestFigures(name, words, min(1.0, p), True)


def rank_sum(one: np.ndarray, other: np.ndarray) -> TestFigures:
    """Mann and Whitney's test of two groups: the p of all arrangements where they can be listed.

    Args:
        one: (n,).
        other: (m,).
    """
    count, total = len(one), len(one) + len(other)
    ranks = stats.rankdata(np.concatenate((one, other)))
    u = float(ranks[:count].sum() - count * (count + 1) / 2)
    name, words = "Mann-Whitney", f"U = {u:g}"
    if total > MOST_IN_GROUPS:
        return TestFigures(name, words, float(stats.mannwhitneyu(one, other, method="asymptotic").pvalue), False)
    # How many choices of so many ranks have each sum, rank by rank (twice the ranks are whole numbers).
    doubled = np.rint(2 * ranks).astype(int)
    ways = np.zeros((count + 1, int(doubled.sum()) + 1))
    ways[0, 0] = 1
    for rank in doubled:
        for size in range(count, 0, -1):
            ways[size, rank:] += ways[size - 1, : ways.shape[1] - rank]
    sums = np.arange(ways.shape[1]) / 2 - count * (count + 1) / 2
    middle = count * len(other) / 2
    p = float(ways[count][np.abs(sums - middle) >= abs(u - middle) - 1e-9].sum() / ways[count].sum())
    return TestFigures(name, words, p, True)


def friedman(table: np.ndarray) -> TestFigures:
    """Friedman's test of three conditions or more: the p of all orders where they can be listed, else drawn by chance.

    Args:
        table: (participants, conditions), without gaps.
    """
    people, width = table.shape
    ranks = np.array([stats.rankdata(row) for row in table])
    observed = _chi_square(ranks.sum(axis=0)[None], ranks)[0]
    words = f"chi2({width - 1}) = {observed:.4g}, n = {people}"
    if observed == 0:
        return TestFigures("Friedman", words, 1.0, True)
    listed = factorial(width) ** (people - 1) <= MOST
    if listed:
        # The first row may keep its order: all others are taken relative to it.
        sums = ranks[:1]
        for row in ranks[1:]:
            orders = np.array(list(permutations(row)))
            sums = (sums[:, None] + orders[None]).reshape(-1, width)
    else:
        rng = np.random.default_rng(SEED)
        sums = np.zeros((DRAWN, width))
        for row in ranks:
            sums += rng.permuted(np.tile(row, (DRAWN, 1)), axis=1)
    reached = int((_chi_square(sums, ranks) >= observed - 1e-9).sum())
    p = reached / len(sums) if listed else (reached + 1) / (DRAWN + 1)
    return TestFigures("Friedman", words, p, listed)


def _chi_square(sums: np.ndarray, ranks: np.ndarray) -> np.ndarray:
    """Friedman's statistic, corrected for ties, of rank sums (m, conditions)."""
    people, width = ranks.shape
    spread = (ranks**2).sum() - people * width * (width + 1) ** 2 / 4
    if spread <= 0:
        return np.zeros(len(sums))
    off = ((sums - people * (width + 1) / 2) ** 2).sum(axis=1)
    return np.asarray((width - 1) * off / spread)


def kruskal(groups: list[np.ndarray]) -> TestFigures:
    """Kruskal and Wallis's test of three groups or more, by arrangements drawn by chance.

    Args:
        groups: of different participants.
    """
    together = np.concatenate(groups)
    ends = np.cumsum([len(g) for g in groups])[:-1]
    if np.ptp(together) == 0:
        return TestFigures("Kruskal-Wallis", f"H({len(groups) - 1}) = 0", 1.0, True)
    h = float(stats.kruskal(*groups).statistic)
    ranks = stats.rankdata(together)
    rng = np.random.default_rng(SEED)
    drawn = rng.permuted(np.tile(ranks, (DRAWN // 5, 1)), axis=1)
    # All but these squared sums is the same for every arrangement.
    reached = sum((part.sum(axis=1) ** 2) / part.shape[1] for part in np.split(drawn, ends, axis=1))
    own = sum(float(part.sum()) ** 2 / len(part) for part in np.split(ranks, ends))
    p = (int((np.asarray(reached) >= own - 1e-9).sum()) + 1) / (len(drawn) + 1)
    return TestFigures("Kruskal-Wallis", f"H({len(groups) - 1}) = {h:.4g}", p, False)


def mcnemar(one: np.ndarray, other: np.ndarray) -> TestFigures:
    """McNemar's exact test of pairs of yes and no.

    Args:
        one: 0 or 1, (n,).
        other: of the same participants, (n,).
    """
    only_one, only_other = int(((one == 1) & (other == 0)).sum()), int(((one == 0) & (other == 1)).sum())
    p = 1.0 if only_one + only_other == 0 else float(stats.binomtest(only_one, only_one + only_other).pvalue)
    return TestFigures("McNemar", f"yes in one only: {only_one} and {only_other}", p, True)


def cochran(table: np.ndarray) -> TestFigures:
    """Cochran's Q of three conditions or more of yes and no: the p of all arrangements, or of some drawn by chance.

    Args:
        table: 0 or 1, (participants, conditions), without gaps.
    """
    # With a person's answers ranked, Friedman's statistic with ties is Q.
    found = friedman(table)
    return TestFigures("Cochran's Q", found.statistic.replace("chi2", "Q"), found.p, found.exact)


def fisher(groups: list[np.ndarray]) -> TestFigures:
    """Fisher's exact test of two groups of yes and no; of more, by arrangements drawn by chance.

    Args:
        groups: 0 or 1, of different participants.
    """
    table = [[int((g == 1).sum()), int((g == 0).sum())] for g in groups]
    words = ", ".join(f"{yes} of {yes + no}" for yes, no in table)
    if len(table) == 2:
        return TestFigures("Fisher exact", words, float(stats.fisher_exact(np.array(table)).pvalue), True)
    return TestFigures("Kruskal-Wallis of yes and no", words, kruskal(groups).p, False)
