"""The test that is chosen fits the study's design and its numbers, and counts people, not sessions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_study.analysis.choosing import adjusted_cells, choose_test
from mbd_study.analysis.comparing import holm, overall_rows, pair_rows, sensitivity_rows
from mbd_study.analysis.describing import condition_rows
from mbd_study.analysis.measured import MeasuredValue, MeasuredValues, MeasureScale, StudyDesign
from published_numbers import DISTANCES, DRUG_1, DRUG_2, groups, measured


def test_a_sample_in_which_nothing_can_be_significant_is_said_to_be_such():
    table = np.array([[1, 2], [1, 3], [2, 3], [2, 4.0]])
    (row,) = sensitivity_rows(measured(table))
    assert row.least_p == pytest.approx(2 / 16)
    assert "no result could be significant" in row.words
    assert pair_rows(measured(table))[0].p == pytest.approx(2 / 16)


@pytest.mark.parametrize(
    ("table", "test"),
    [
        (np.array([[0, 1], [0, 1], [1, 1], [0, 1.0]]), "McNemar"),
        (np.array([[0, 1, 1], [0, 1, 0], [1, 1, 0], [0, 1, 1.0]]), "Cochran's Q"),
        (np.array([[1, 3], [2, 4], [2, 5], [1, 2.0]]), "Wilcoxon signed-rank"),
        (np.array([[1, 3, 2], [2, 4, 5], [2, 5, 4], [1, 2, 3.0]]), "Friedman"),
        # Two boys lie far off the others, and make the residuals of all 27 not normal.
        (DISTANCES, "Friedman"),
        (np.delete(DISTANCES, (8, 12), axis=0), "linear mixed model"),
        (np.exp(3 * np.random.default_rng(1).normal(size=(20, 2))), "Wilcoxon signed-rank"),
    ],
)
def test_within_participants_the_test_fits_the_numbers_and_states_why(table: np.ndarray, test: str):
    of_table = measured(table)
    chosen = choose_test(of_table)
    assert of_table.design is StudyDesign.WITHIN
    assert chosen.figures.test == test
    assert len(chosen.why) > 10


def test_between_participants_the_test_fits_the_numbers():
    levels = [np.array([1.0, 2, 2, 3]), np.array([3.0, 4, 4, 5]), np.array([2.0, 2, 3, 3])]
    answers = [np.array([1.0, 1, 0, 1]), np.array([0.0, 0, 0, 1])]
    assert choose_test(groups(*levels[:2], scale=MeasureScale.LEVELS)).figures.test == "Mann-Whitney"
    assert choose_test(groups(*levels, scale=MeasureScale.LEVELS)).figures.test == "Kruskal-Wallis"
    assert choose_test(groups(*answers, scale=MeasureScale.YES_NO)).figures.test == "Fisher exact"
    assert choose_test(groups(DRUG_1, DRUG_2, DRUG_1 + 1)).figures.test == "Welch's analysis of variance"


def test_a_participant_of_many_sessions_counts_once():
    """Ten values of one person and one of each of three others: the mean is that of four people."""
    values = [MeasuredValue("p0", "a", 10.0 + 0.1 * k) for k in range(10)]
    values += [MeasuredValue(f"p{k}", "a", 0.5 * k) for k in (1, 2, 3)]
    values += [MeasuredValue(f"p{k}", "b", 1.25 * k) for k in range(4)]
    (row, _) = condition_rows(MeasuredValues("m", MeasureScale.NUMBERS, tuple(values)))
    assert (row.participants, row.values) == (4, 13)
    assert row.mean == pytest.approx((10.45 + 0.5 + 1.0 + 1.5) / 4)


def test_many_sessions_of_two_people_show_nothing_about_people():
    """Ten sessions each, far apart by condition: with one degree of freedom left nothing is sure."""
    rng = np.random.default_rng(3)
    values = [
        MeasuredValue(f"p{p}", c, 10.0 * (c == "a") + 4.0 * p * (c == "a") + rng.normal())
        for p in range(2)
        for c in "ab"
        for _ in range(10)
    ]
    two = MeasuredValues("m", MeasureScale.NUMBERS, tuple(values))
    assert choose_test(two).figures.p > 0.05
    one = MeasuredValues("m", MeasureScale.NUMBERS, tuple(v for v in values if v.participant == "p0"))
    assert choose_test(one) is None


@given(st.integers(0, 2**31))
@settings(max_examples=10, deadline=None)
def test_a_task_that_is_harder_for_all_makes_no_difference_between_conditions(seed: int):
    """Whoever did which task where, so long as each task is met in both conditions by somebody."""
    rng = np.random.default_rng(seed)
    plan = [(p, c, t) for p in range(6) for c in "ab" for t in "xyz" if (p, c, t) not in {(0, "a", "x"), (1, "b", "z")}]
    noise = {(p, c, t): rng.normal() for p, c, t in plan}

    def made(harder: float) -> MeasuredValues:
        values = [MeasuredValue(f"p{p}", c, noise[p, c, t] + harder * "xyz".index(t), t) for p, c, t in plan]
        return MeasuredValues("m", MeasureScale.NUMBERS, tuple(values))

    easy, hard = adjusted_cells(made(0.0)), adjusted_cells(made(50.0))
    assert easy[1]
    assert np.diff(hard[0], axis=1) == pytest.approx(np.diff(easy[0], axis=1), abs=1e-6)


def test_who_met_not_every_condition_is_in_the_mixed_model_and_not_in_the_rank_test():
    table = np.delete(DISTANCES, (8, 12), axis=0)
    table[0, 1] = np.nan
    numbers = choose_test(measured(table))
    levels = choose_test(measured(np.round(table), MeasureScale.LEVELS))
    assert (numbers.figures.test, numbers.participants) == ("linear mixed model", 25)
    assert (levels.figures.test, levels.participants) == ("Friedman", 24)
    assert overall_rows([measured(table)])[0].design.endswith("24 of 25 in every condition")


@given(st.lists(st.none() | st.floats(0, 1), max_size=8))
def test_holms_p_is_no_smaller_keeps_the_order_and_is_that_of_the_definition(values: list[float | None]):
    raised = holm(values)
    known = [(p, q) for p, q in zip(values, raised, strict=True) if p is not None]
    assert all(q is not None and p <= q <= 1 for p, q in known)
    assert all(r is None for p, r in zip(values, raised, strict=True) if p is None)
    if known:
        least = min(p for p, _ in known)
        assert min(q for _, q in known) == pytest.approx(min(1, least * len(known)))


@given(st.integers(0, 2**31))
@settings(max_examples=8, deadline=None)
def test_the_order_and_the_names_of_participants_change_nothing(seed: int):
    rng = np.random.default_rng(seed)
    table = rng.normal(size=(8, 3))
    shuffled = table[rng.permutation(8)]
    one, other = overall_rows([measured(table)])[0], overall_rows([measured(shuffled)])[0]
    assert (one.test, one.participants) == (other.test, other.participants)
    assert one.p == pytest.approx(other.p, rel=1e-6, abs=2e-3 if "Friedman" in one.test else 0)
