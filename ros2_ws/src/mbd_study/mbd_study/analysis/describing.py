"""A condition's values as a paper states them: mean, spread, and the interval that likely holds the true mean.

The unit is the participant: of several sessions of one the mean counts once, as they are not independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from mbd_study.analysis.measured import MeasuredValues, MeasureScale

RESAMPLES = 9999
SEED = 20170306  # of the bootstrap: equal tables give equal intervals


@dataclass(frozen=True)
class ConditionRow:
    """A measure in a condition; what the interval is made by stands in ``ci_by``. One row of descriptives.csv."""

    measure: str
    condition: str
    participants: int
    values: int
    mean: float
    sd: float | None
    ci_low: float | None
    ci_high: float | None
    ci_by: str
    median: float
    quartile_low: float
    quartile_high: float


def condition_rows(measured: MeasuredValues) -> tuple[ConditionRow, ...]:
    """A row for each condition."""
    return tuple(_row(measured, name) for name in measured.conditions)


def _row(measured: MeasuredValues, condition: str) -> ConditionRow:
    means = measured.group(condition)
    count = int(measured.counts[:, measured.conditions.index(condition)].sum())
    low, high, how = mean_interval(means, measured.scale, single=count == len(means))
    quartiles = np.quantile(means, (0.25, 0.5, 0.75))
    return ConditionRow(
        measure=measured.name,
        condition=condition,
        participants=len(means),
        values=count,
        mean=float(means.mean()),
        sd=float(means.std(ddof=1)) if len(means) > 1 else None,
        ci_low=low,
        ci_high=high,
        ci_by=how,
        median=float(quartiles[1]),
        quartile_low=float(quartiles[0]),
        quartile_high=float(quartiles[2]),
    )


def mean_interval(means: np.ndarray, scale: MeasureScale, *, single: bool) -> tuple[float | None, float | None, str]:
    """The 95 % interval of a mean, and how it is made.

    Args:
        means: the participants', (n,).
        scale: of the measure.
        single: each is one value, no mean of several.
    """
    if scale is MeasureScale.YES_NO and single:
        return (*wilson_interval(int(means.sum()), len(means)), "Wilson")
    if len(means) < 2:
        return None, None, "one participant gives none"
    if scale is MeasureScale.NUMBERS:
        half = float(stats.t.ppf(0.975, len(means) - 1) * means.std(ddof=1) / np.sqrt(len(means)))
        return float(means.mean()) - half, float(means.mean()) + half, "t"
    if np.ptp(means) == 0:
        return None, None, "all equal: gives none"
    return (*bootstrap_interval(means), "bootstrap (BCa)")


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a share.

    Args:
        successes: of ``count``.
        count: of trials, at least 1.

    References:
        Wilson, E. B. (1927): Probable inference, the law of succession, and statistical inference. JASA 22, 209-212.
    """
    interval = stats.binomtest(successes, count).proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


def bootstrap_interval(values: np.ndarray) -> tuple[float, float]:
    """The 95 % interval of a mean by bootstrap, bias-corrected and accelerated; equal for equal values.

    Args:
        values: not all equal, (n,).
    """
    found = stats.bootstrap(
        (values,), np.mean, n_resamples=RESAMPLES, method="BCa", rng=np.random.default_rng(SEED), vectorized=True
    )
    return float(found.confidence_interval.low), float(found.confidence_interval.high)
