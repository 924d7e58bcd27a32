"""The tables a paper prints of one study: a row for each test, each pair of conditions, and what could be found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from mbd_study.analysis import effects, exact_tests, sensitivity
from mbd_study.analysis.choosing import ChosenTest, choose_test, welch
from mbd_study.analysis.exact_tests import TestFigures
from mbd_study.analysis.measured import MeasuredValues, MeasureScale, StudyDesign


@dataclass(frozen=True)
class OverallRow:
    """A measure's test over all conditions. One row of tests.csv; ``p_holm`` takes the other measures into account."""

    measure: str
    design: str
    participants: int
    test: str
    statistic: str
    p: float | None
    p_holm: float | None
    effect: str
    effect_size: float | None
    why: str
    other_test: str
    other_p: float | None


@dataclass(frozen=True)
class PairRow:
    """Two conditions, the first minus the second. One row of pairs.csv; ``p_holm``: over the measure's pairs."""

    measure: str
    one: str
    other: str
    participants: int
    difference: float
    ci_low: float | None
    ci_high: float | None
    effect: str
    effect_size: float | None
    test: str
    p: float | None
    p_holm: float | None


@dataclass(frozen=True)
class SensitivityRow:
    """What a pair of conditions could show. One row of sensitivity.csv.

    ``least_effect`` is found with 80 % probability, by a two-sided test at ``level`` (0.05, shared by the pairs of a
    measure); ``least_difference`` the same in the measure's unit; ``needed_...``: participants (of each group) for
    Cohen's small, medium and large effect; ``least_p``: that of an exact test, whatever the values.
    """

    measure: str
    one: str
    other: str
    participants: str
    level: float
    least_effect: float | None
    least_difference: float | None
    power_small: float
    power_medium: float
    power_large: float
    needed_small: int
    needed_medium: int
    needed_large: int
    least_p: float
    words: str


def holm(values: Sequence[float | None]) -> tuple[float | None, ...]:
    """P values of several tests, raised as Holm (1979) does; None stays.

    Args:
        values: as they are.
    """
    order = sorted((p, k) for k, p in enumerate(values) if p is not None)
    raised: list[float | None] = [None] * len(values)
    least = 0.0
    for place, (p, k) in enumerate(order):
        least = max(least, min(1.0, p * (len(order) - place)))
        raised[k] = least
    return tuple(raised)


def overall_rows(measures: Sequence[MeasuredValues]) -> tuple[OverallRow, ...]:
    """A row for each measure, with Holm's p over all of them."""
    rows = [_test_row(measured, choose_test(measured)) for measured in measures]
    return tuple(replace(row, p_holm=p) for row, p in zip(rows, holm([r.p for r in rows]), strict=True))


def _test_row(measured: MeasuredValues, chosen: ChosenTest | None) -> OverallRow:
    words = measured.design.value
    if measured.design is StudyDesign.WITHIN and not measured.complete.all():
        words += f", {int(measured.complete.sum())} of {len(measured.participants)} in every condition"
    if chosen is None:
        why = "too few participants or conditions for any test"
        return OverallRow(measured.name, words, len(measured.participants), "", "", None, None, "", None, why, "", None)
    effect, size = "", None
    if measured.design is StudyDesign.WITHIN and len(measured.conditions) > 2 and measured.complete.sum() > 1:
        effect, size = "Kendall's W", effects.kendalls_w(measured.means[measured.complete])
    f, other = chosen.figures, chosen.other
    return OverallRow(
        measured.name, words, chosen.participants, f.test + (" (exact)" if f.exact else ""), f.statistic, f.p, None,
        effect, size, chosen.why, other.test if other else "", other.p if other else None,
    )  # fmt: skip


def pair_rows(measured: MeasuredValues) -> tuple[PairRow, ...]:
    """A row for each two conditions, by the kind of test that was chosen for all of them."""
    chosen = choose_test(measured)
    rows = [_pair_row(measured, chosen, one, other) for one, other in combinations(measured.conditions, 2)]
    return tuple(replace(row, p_holm=p) for row, p in zip(rows, holm([r.p for r in rows]), strict=True))


def _pair_row(measured: MeasuredValues, chosen: ChosenTest | None, one: str, other: str) -> PairRow:
    paired = measured.design is StudyDesign.WITHIN
    first, second = measured.pairs(one, other) if paired else (measured.group(one), measured.group(other))
    people = len(first) if paired else len(first) + len(second)
    answers = measured.scale is MeasureScale.YES_NO and not measured.repeated
    if min(len(first), len(second)) < 1:
        return PairRow(measured.name, one, other, 0, np.nan, None, None, "", None, "nobody met both", None, None)
    interval: tuple[float, float | None, float | None]
    effect, size = "difference of shares", _difference(first, second)
    if answers:
        interval = effects.share_difference(first, second, paired=paired)
    elif chosen is None or chosen.by_ranks:
        interval = effects.mean_difference(first, second, paired=paired)
        effect, size = "rank-biserial r", effects.rank_biserial(first, second, paired=paired)
    else:
        interval = effects.mean_difference(first, second, paired=paired)
        effect = "Hedges' g_av" if paired else "Hedges' g"
        size = effects.hedges_g_av(first, second) if paired else effects.hedges_g(first, second)
    if min(len(first), len(second)) < 2:
        effect, size = "", None
    figures: TestFigures | None = None
    if chosen is not None and min(len(first), len(second)) > 1:
        if chosen.model is not None:
            value, half, figures = _contrast(measured, chosen, one, other)
            interval, people = (value, value - half, value + half), chosen.participants
        else:
            figures = _pair_test(first, second, paired=paired, answers=answers, ranks=chosen.by_ranks)
    return PairRow(
        measured.name, one, other, people, *interval, effect, size,
        figures.test if figures else "", figures.p if figures else None, None,
    )  # fmt: skip


def _difference(one: np.ndarray, other: np.ndarray) -> float | None:
    return float(one.mean() - other.mean())


def _contrast(measured: MeasuredValues, chosen: ChosenTest, one: str, other: str) -> tuple[float, float, TestFigures]:
    model = chosen.model
    if model is None:
        raise ValueError("the test that was chosen is no mixed model")
    weights = np.zeros(len(model.coefficients))
    columns = [measured.conditions.index(name) for name in (one, other)]
    for column, sign in zip(columns, (1.0, -1.0), strict=True):
        if column:
            weights[column] = sign
    degrees = float(min(model.degrees[[c for c in columns if c]]))
    value, t, p, half = model.contrast(weights, degrees)
    return value, half, TestFigures("linear mixed model", f"t({degrees:g}) = {t:.3f}", p, False)


def _pair_test(one: np.ndarray, other: np.ndarray, *, paired: bool, answers: bool, ranks: bool) -> TestFigures:
    if answers:
        return exact_tests.mcnemar(one, other) if paired else exact_tests.fisher([one, other])
    if ranks:
        return exact_tests.signed_rank(one, other) if paired else exact_tests.rank_sum(one, other)
    return welch([one, other])


def sensitivity_rows(measured: MeasuredValues) -> tuple[SensitivityRow, ...]:
    """A row for each two conditions."""
    pairs = list(combinations(measured.conditions, 2))
    chosen = choose_test(measured)
    return tuple(_sensitivity(measured, chosen, *pair, sensitivity.LEVEL / len(pairs)) for pair in pairs)


def _sensitivity(
    measured: MeasuredValues, chosen: ChosenTest | None, one: str, other: str, level: float
) -> SensitivityRow:
    paired = measured.design is StudyDesign.WITHIN
    first, second = measured.pairs(one, other) if paired else (measured.group(one), measured.group(other))
    counts = (len(first), None) if paired else (len(first), len(second))
    by_rank = chosen is None or chosen.by_ranks
    # A rank test finds what a t test of so much fewer finds.
    used = tuple(None if n is None else int(n * sensitivity.RANKS) if by_rank else n for n in counts)
    size = used[0] or 0
    least = sensitivity.least_effect(size, used[1], level)
    spread = 0.0
    if min(len(first), len(second)) > 1:
        spread = float(
            (first - second).std(ddof=1) if paired else np.sqrt((first.var(ddof=1) + second.var(ddof=1)) / 2)
        )
    difference = least * spread if least is not None and spread > 0 else None
    if measured.scale is MeasureScale.YES_NO and difference is not None and difference > 1:
        least = difference = None  # shares differ by 1 at most
    least_p = sensitivity.least_p(*counts)
    people = f"{len(first)} pair{'s' * (len(first) != 1)}" if paired else f"{len(first)} and {len(second)}"
    powers = [sensitivity.t_power(d, size, used[1], level) for d in (0.2, 0.5, 0.8)]
    needs = [sensitivity.needed(d, paired=paired, level=level) for d in (0.2, 0.5, 0.8)]
    if by_rank:
        needs = [int(np.ceil(n / sensitivity.RANKS)) for n in needs]
    if least_p > level and by_rank:
        words = f"no result could be significant: the least p there is with {people} is {least_p:.2g}"
    elif least is None:
        words = f"{people}: too few for a difference of any size to be found with 80 % probability"
    else:
        unit = f", here {difference:.3g} in the measure's unit" if difference is not None else ""
        words = f"differences below {least:.2f} standard deviations{unit} are missed more often than in one of five"
    return SensitivityRow(
        measured.name, one, other, people, level, least, difference,
        powers[0], powers[1], powers[2], needs[0], needs[1], needs[2], least_p, words,
    )  # fmt: skip
