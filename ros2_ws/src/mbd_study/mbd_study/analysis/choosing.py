"""Which test fits a measure: by what its numbers mean and how the study was made, with the reason in words.

Numbers whose residuals look normal: a linear mixed model with a random intercept for each participant (which is the
paired t test, or the analysis of variance with repeated measures, where each met every condition), or Welch's test of
groups. Ratings, small counts and what is not normal: Wilcoxon or Friedman within participants, Mann-Whitney or
Kruskal-Wallis between them. Yes and no: McNemar or Cochran's Q, Fisher.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from mbd_study.analysis import exact_tests
from mbd_study.analysis.exact_tests import TestFigures
from mbd_study.analysis.measured import MeasuredValues, MeasureScale, StudyDesign
from mbd_study.analysis.mixed_model import MixedModelFit, fit_mixed_model

# Below this Shapiro-Wilk p the residuals are taken for not normal; t and F withstand less than that.
NOT_NORMAL = 0.01


@dataclass(frozen=True)
class ChosenTest:
    """The test of whether the conditions differ.

    Attributes:
        figures: of the test that fits.
        why: it was chosen.
        participants: that it uses.
        other: figures of the other kind of test, for who doubts the choice; None where there is none.
        model: the mixed model, where that is the test.
        by_ranks: a rank or count test was chosen.
    """

    figures: TestFigures
    why: str
    participants: int
    other: TestFigures | None = None
    model: MixedModelFit | None = None
    by_ranks: bool = True


def choose_test(measured: MeasuredValues) -> ChosenTest | None:
    """The test that fits; None: fewer than two conditions, or fewer than two participants in one of them.

    Args:
        measured: of the conditions.
    """
    within = measured.design is StudyDesign.WITHIN
    usable = int(measured.complete.sum()) if within else min(len(measured.group(c)) for c in measured.conditions)
    if len(measured.conditions) < 2 or (usable < 2 and not within):
        return None
    if measured.scale is MeasureScale.YES_NO and not measured.repeated:
        return _of_answers(measured, within)
    ranks = _by_ranks(measured, within) if usable >= 2 else None
    if measured.scale is not MeasureScale.NUMBERS:
        if ranks is None:
            return None
        what = "shares of yes" if measured.scale is MeasureScale.YES_NO else "levels whose distances are not known"
        return ChosenTest(ranks, f"{what}, compared by rank; {_unit(measured)}", _rank_count(measured, within))
    return _of_numbers(measured, within, ranks)


def adjusted_cells(measured: MeasuredValues) -> tuple[np.ndarray, bool]:
    """Each participant's mean in each condition, (participants, conditions), what the blocks add taken out first.

    So who did the hard task in one condition only does not count as worse there. NaN: no value. The second
    is whether blocks were taken out: not where there is but one, or where they cannot be told from the cells.

    Args:
        measured: of the conditions.
    """
    values = np.array([v.value for v in measured.values])
    cells = [(v.participant, v.condition) for v in measured.values]
    names = list(dict.fromkeys(cells))
    design = np.array([[cell == name for name in names] for cell in cells], dtype=float)
    blocks = np.array([[v.block == b for b in measured.blocks[1:]] for v in measured.values], dtype=float)
    both = np.hstack([design, blocks.reshape(len(values), -1)])
    if len(measured.blocks) == 1 or np.linalg.matrix_rank(both) < both.shape[1]:
        return measured.means, False
    effects = np.append(0.0, np.linalg.lstsq(both, values)[0][len(names) :])
    added = {b: float(e - effects.mean()) for b, e in zip(measured.blocks, effects, strict=True)}
    plain = [replace(v, value=v.value - added[v.block]) for v in measured.values]
    return replace(measured, values=tuple(plain)).means, True


def mixed_model_of(measured: MeasuredValues) -> tuple[MixedModelFit, bool]:
    """The model of the participants' means, conditions as columns 1.., and whether blocks were taken out before.

    Of the means, not of each value: values of one participant in one condition are not independent, whatever the number
    of sessions.

    Args:
        measured: of the conditions.

    Raises:
        ValueError: there are too few participants.
    """
    cells, blocks = adjusted_cells(measured)
    people, columns = np.nonzero(~np.isnan(cells))
    design = np.column_stack([np.ones(len(people)), *(columns == c for c in range(1, cells.shape[1]))]).astype(float)
    return fit_mixed_model(cells[people, columns], design, people), blocks


def welch(groups: list[np.ndarray]) -> TestFigures:
    """Welch's test of groups with spreads of their own: t for two, F for more.

    Args:
        groups: of different participants, two values or more in each.

    References:
        Welch, B. L. (1951): On the comparison of several mean values. Biometrika 38, 330-336.
    """
    count = np.array([len(g) for g in groups])
    means = np.array([g.mean() for g in groups])
    weights = count / np.array([g.var(ddof=1) for g in groups])
    k = len(groups)
    middle = (weights * means).sum() / weights.sum()
    lack = ((1 - weights / weights.sum()) ** 2 / (count - 1)).sum()
    f = (weights * (means - middle) ** 2).sum() / (k - 1) / (1 + 2 * (k - 2) * lack / (k**2 - 1))
    degrees = (k**2 - 1) / (3 * lack)
    p = float(stats.f.sf(f, k - 1, degrees))
    if k == 2:
        return TestFigures("Welch's t", f"t({degrees:.1f}) = {np.sign(means[0] - means[1]) * f**0.5:.3f}", p, False)
    return TestFigures("Welch's analysis of variance", f"F({k - 1}, {degrees:.1f}) = {f:.3f}", p, False)


def _unit(measured: MeasuredValues) -> str:
    return "of each participant's means, as there are several values of one" if measured.repeated else "one value each"


def _rank_count(measured: MeasuredValues, within: bool) -> int:
    return int(measured.complete.sum()) if within else len(measured.participants)


def _of_answers(measured: MeasuredValues, within: bool) -> ChosenTest | None:
    table = measured.means[measured.complete]
    if within and len(table) < 2:
        return None
    if not within:
        figures = exact_tests.fisher([measured.group(c) for c in measured.conditions])
    elif len(measured.conditions) == 2:
        figures = exact_tests.mcnemar(table[:, 0], table[:, 1])
    else:
        figures = exact_tests.cochran(table)
    why = f"yes or no, {'each participant in every condition' if within else 'other participants in each condition'}"
    return ChosenTest(figures, why, _rank_count(measured, within))


def _by_ranks(measured: MeasuredValues, within: bool) -> TestFigures:
    if within:
        table = measured.means[measured.complete]
        if len(measured.conditions) == 2:
            return exact_tests.signed_rank(table[:, 0], table[:, 1])
        return exact_tests.friedman(table)
    groups = [measured.group(c) for c in measured.conditions]
    return exact_tests.rank_sum(*groups) if len(groups) == 2 else exact_tests.kruskal(groups)


def _of_numbers(measured: MeasuredValues, within: bool, ranks: TestFigures | None) -> ChosenTest | None:
    model, used = None, ""
    figures: TestFigures | None = None
    cells, blocks = adjusted_cells(measured)
    groups = [column[~np.isnan(column)] for column in cells.T]
    taken = ", what the blocks add taken out first" if blocks else ""
    if within:
        try:
            model, _ = mixed_model_of(measured)
            f, top, below, p = model.wald(range(1, len(measured.conditions)))
            residuals = model.residuals
            figures = TestFigures("linear mixed model", f"F({top}, {below:g}) = {f:.3f}", p, False)
            used = f"{_unit(measured)}{taken}; a random intercept for each participant"
        except ValueError as error:
            used = f"no mixed model: {error}"
    elif all(len(g) > 1 and np.ptp(g) > 0 for g in groups):
        figures = welch(groups)
        residuals = np.concatenate([g - g.mean() for g in groups])
        used = f"{_unit(measured)}{taken}; groups may spread differently"
    if figures is None:
        return None if ranks is None else ChosenTest(ranks, f"compared by rank; {used}", _rank_count(measured, within))
    normal = float(stats.shapiro(residuals).pvalue) if len(residuals) >= 3 and np.ptp(residuals) > 0 else 1.0
    if normal < NOT_NORMAL and ranks is not None:
        why = f"the residuals are not normal (Shapiro-Wilk p = {normal:.2g}): by rank; {_unit(measured)}"
        return ChosenTest(ranks, why, _rank_count(measured, within), other=figures)
    once = within and bool(measured.complete.all())
    same = ""
    if once:
        same = "; the same as " + (
            "the paired t test" if len(groups) == 2 else "repeated-measures analysis of variance"
        )
    why = f"numbers, residuals near normal (Shapiro-Wilk p = {normal:.2g}); {used}{same}"
    return ChosenTest(figures, why, len(measured.participants), other=ranks, model=model, by_ranks=False)
