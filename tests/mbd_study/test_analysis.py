"""Means, intervals, tests and power are those of R, scipy and the literature, and fit the study's design."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_study.analysis import effects, exact_tests, sensitivity
from mbd_study.analysis.choosing import adjusted_cells, choose_test, welch
from mbd_study.analysis.comparing import holm, overall_rows, pair_rows, sensitivity_rows
from mbd_study.analysis.describing import condition_rows, wilson_interval
from mbd_study.analysis.measured import MeasuredValue, MeasuredValues, MeasureScale, StudyDesign, scale_of
from mbd_study.analysis.mixed_model import fit_mixed_model
from scipy import stats


def numbers(text: str) -> np.ndarray:
    return np.array([float(word) for word in text.split()])


# R's `sleep` (Student 1908): ten people, two drugs; more hours of sleep.
DRUG_1 = np.array([0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0])
DRUG_2 = np.array([1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4])
# R's `depression` (Hollander & Wolfe 1973), in the help of wilcox.test.
FIRST = np.array([1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30])
SECOND = np.array([0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29])
# R's `RoundingTimes` (Hollander & Wolfe 1973), in the help of friedman.test: 22 players, three methods.
ROUNDING = numbers(
    """
    5.4 5.5 5.55 5.85 5.7 5.75 5.2 5.6 5.5 5.55 5.5 5.4 5.9 5.85 5.7 5.45 5.55 5.6 5.4 5.4 5.35 5.45 5.5 5.35
    5.25 5.15 5 5.85 5.8 5.7 5.25 5.2 5.1 5.65 5.55 5.45 5.6 5.35 5.45 5.05 5 4.95 5.5 5.5 5.4 5.45 5.55 5.5
    5.55 5.55 5.35 5.45 5.5 5.55 5.5 5.45 5.25 5.65 5.6 5.4 5.7 5.65 5.55 6.3 6.3 6.25
    """
).reshape(-1, 3)
# R's `InsectSprays` (Beall 1942): insects on twelve plots of each of six sprays.
SPRAYS = numbers(
    """
    10 7 20 14 14 12 10 23 17 20 14 13 11 17 21 11 16 14 17 17 19 21 7 13 0 1 7 2 3 1 2 1 3 0 1 4 3 5 12 6 4 3 5
    5 5 5 2 4 3 5 3 5 3 6 1 1 3 2 6 4 11 9 15 22 15 16 13 10 26 26 24 13
    """
).reshape(6, 12)
# nlme's `Orthodont` (Potthoff & Roy 1964): a distance at the ages 8, 10, 12 and 14 [mm].
ORTHODONT = """
M01 26 25 29 31; M02 21.5 22.5 23 26.5; M03 23 22.5 24 27.5; M04 25.5 27.5 26.5 27; M05 20 23.5 22.5 26; M06
24.5 25.5 27 28.5; M07 22 22 24.5 26.5; M08 24 21.5 24.5 25.5; M09 23 20.5 31 26; M10 27.5 28 31 31.5; M11 23
23 23.5 25; M12 21.5 23.5 24 28; M13 17 24.5 26 29.5; M14 22.5 25.5 25.5 26; M15 23 24.5 26 30; M16 22 21.5
23.5 25; F01 21 20 21.5 23; F02 21 21.5 24 25.5; F03 20.5 24 24.5 26; F04 23.5 24.5 25 26.5; F05 21.5 23 22.5
23.5; F06 20 21 21 22.5; F07 21.5 22.5 23 25; F08 23 23 23.5 24; F09 20 21 22 21.5; F10 16.5 19 19 19.5; F11
24.5 25 28 28
"""
PEOPLE = [line.split() for line in ORTHODONT.replace("\n", " ").split(";")]
DISTANCES = np.array([[float(v) for v in words[1:]] for words in PEOPLE])
GIRLS = np.array([words[0].startswith("F") for words in PEOPLE])


def measured(table: np.ndarray, scale: MeasureScale | None = None) -> MeasuredValues:
    """A measure of (participants, conditions); NaN: not measured."""
    values = [
        MeasuredValue(f"p{p}", f"c{c}", float(table[p, c]))
        for p, c in product(range(table.shape[0]), range(table.shape[1]))
        if not np.isnan(table[p, c])
    ]
    return MeasuredValues("m", scale or scale_of([v.value for v in values]), tuple(values))


def groups(*values: np.ndarray, scale: MeasureScale = MeasureScale.NUMBERS) -> MeasuredValues:
    """A measure of other participants in each condition."""
    rows = [MeasuredValue(f"p{c}_{k}", f"c{c}", float(v)) for c, g in enumerate(values) for k, v in enumerate(g)]
    return MeasuredValues("m", scale, tuple(rows))


def test_the_mixed_model_is_that_of_nlme():
    """lme(distance ~ age + Sex, random = ~1 | Subject, data = Orthodont): Pinheiro & Bates (2000), and R 4.2."""
    count = DISTANCES.size
    design = np.column_stack([np.ones(count), np.tile([8.0, 10, 12, 14], 27), np.repeat(GIRLS, 4)])
    fit = fit_mixed_model(DISTANCES.ravel(), design, np.repeat(np.arange(27), 4))
    assert fit.coefficients == pytest.approx([17.706713, 0.660185, -2.321023], abs=1e-6)
    assert np.sqrt(np.diag(fit.covariance)) == pytest.approx([0.8339225, 0.0616059, 0.7614168], abs=1e-6)
    assert (fit.between, fit.within) == pytest.approx((1.807425, 1.431592), abs=1e-5)
    assert fit.log_likelihood == pytest.approx(-218.7563, abs=1e-4)
    assert fit.degrees[1:].tolist() == [80, 25]
    assert fit.contrast(np.array([0.0, 0.0, 1.0]), 25)[1:3] == pytest.approx((-3.048294, 0.005375056), abs=1e-6)


def test_the_mixed_model_is_that_of_nlme_where_values_are_missing():
    """The rows 2, 7 and 30 are left out; anova(lme(distance ~ factor(age) + Sex, ...), type = "marginal") by R 4.2."""
    kept = np.setdiff1d(np.arange(108), [1, 6, 29])
    ages = np.tile(np.arange(4), 27)
    design = np.column_stack([np.ones(108), *(ages == k for k in (1, 2, 3)), np.repeat(GIRLS, 4)]).astype(float)
    fit = fit_mixed_model(DISTANCES.ravel()[kept], design[kept], np.repeat(np.arange(27), 4)[kept])
    assert fit.coefficients == pytest.approx([23.168617, 1.143590, 2.520955, 3.907407, -2.413878], abs=1e-5)
    assert fit.wald([1, 2, 3])[:3] == pytest.approx((37.7524, 3, 75), abs=1e-3)
    assert fit.wald([4])[:3] == pytest.approx((9.8580, 1, 25), abs=1e-3)
    assert (fit.between, fit.within) == pytest.approx((1.825309, 1.425625), abs=1e-5)


@given(st.integers(3, 12), st.integers(0, 2**31))
@settings(max_examples=25, deadline=None)
def test_of_two_conditions_met_once_by_all_the_mixed_model_is_the_paired_t_test(people: int, seed: int):
    rng = np.random.default_rng(seed)
    table = 3 * rng.normal(size=(people, 1)) + rng.normal(size=(people, 2))
    fit_of = choose_test(measured(table))
    if fit_of is None or fit_of.by_ranks or fit_of.model is None or fit_of.model.between == 0:
        return  # without a share of the participants' own the model takes the values for independent
    assert fit_of.figures.p == pytest.approx(float(stats.ttest_rel(table[:, 0], table[:, 1]).pvalue), rel=1e-5)


def test_sleep_comes_out_as_in_r():
    """t.test(paired = TRUE): t = -4.0621, df = 9, p = 0.002833, [-2.4598858, -0.7001142]."""
    both = measured(np.column_stack([DRUG_1, DRUG_2]))
    (row,), (pair,) = overall_rows([both]), pair_rows(both)
    assert row.test == "linear mixed model"
    assert row.p == pytest.approx(0.002833, abs=1e-6)
    assert "paired t test" in row.why
    assert (pair.difference, pair.ci_low, pair.ci_high) == pytest.approx((-1.58, -2.4598858, -0.7001142), abs=1e-6)
    assert effects.cohens_d_z(DRUG_1, DRUG_2) == pytest.approx(-4.0621 / np.sqrt(10), abs=1e-4)
    apart = groups(DRUG_1, DRUG_2)
    (row,), (pair,) = overall_rows([apart]), pair_rows(apart)
    assert (row.test, row.p) == ("Welch's t", pytest.approx(0.07939, abs=1e-5))
    assert (pair.ci_low, pair.ci_high) == pytest.approx((-3.3654832, 0.2054832), abs=1e-6)


def test_rank_tests_come_out_as_in_r_and_where_r_approximates_as_by_all_arrangements():
    assert exact_tests.signed_rank(FIRST, SECOND).p == pytest.approx(0.0390625)
    # Nine differences other than 0, all of one sign: 2 of 2^9.
    assert exact_tests.signed_rank(DRUG_1, DRUG_2).p == pytest.approx(2 / 512)
    friedman = exact_tests.friedman(ROUNDING)
    assert friedman.statistic.startswith("chi2(2) = 11.14")
    assert friedman.p == pytest.approx(0.003805, abs=0.0015)
    kruskal = exact_tests.kruskal(list(SPRAYS))
    assert kruskal.statistic == "H(5) = 54.69"
    assert kruskal.p < 0.001
    spread = welch(list(SPRAYS))
    assert spread.statistic == "F(5, 30.0) = 36.065"
    assert spread.p == pytest.approx(7.999e-12, rel=1e-3)


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=2, max_size=6))
@settings(max_examples=40, deadline=None)
def test_a_rank_tests_p_is_the_share_of_arrangements_as_far_off_with_ties_and_zeros(pairs: list[tuple[int, int]]):
    one, other = (np.array(v, dtype=float) for v in zip(*pairs, strict=True))
    d = (one - other)[one != other]
    if len(d):
        ranks = stats.rankdata(np.abs(d))
        sums = np.array(
            [sum(r for r, s in zip(ranks, signs, strict=True) if s) for signs in product((0, 1), repeat=len(d))]
        )
        own = ranks[d > 0].sum()
        expected = np.mean(np.abs(sums - ranks.sum() / 2) >= abs(own - ranks.sum() / 2) - 1e-9)
        assert exact_tests.signed_rank(one, other).p == pytest.approx(expected)
    ranks = stats.rankdata(np.r_[one, other])
    sums = np.array([sum(chosen) for chosen in combinations(ranks, len(one))])
    expected = np.mean(np.abs(sums - sums.mean()) >= abs(ranks[: len(one)].sum() - sums.mean()) - 1e-9)
    assert exact_tests.rank_sum(one, other).p == pytest.approx(expected)


def test_cochrans_q_and_mcnemar_are_those_of_the_literature():
    # Conover (1999), Practical Nonparametric Statistics: twelve games, three sportsmen's forecasts; Q = 2.8.
    forecasts = [(1, 1, 1), (1, 1, 1), (0, 1, 0), (1, 1, 0), (0, 0, 0), (1, 1, 1)]
    forecasts += [(1, 1, 1), (1, 1, 0), (0, 0, 1), (0, 1, 0), (1, 1, 1), (1, 1, 1)]
    assert exact_tests.cochran(np.array(forecasts, dtype=float)).statistic.startswith("Q(2) = 2.8")
    # Agresti (1990), in the help of R's mcnemar.test: 150 and 86 changed their mind; the exact p by binom.test.
    one, other = (np.repeat(v, (150, 86)) for v in ((1.0, 0.0), (0.0, 1.0)))
    assert exact_tests.mcnemar(one, other).p == pytest.approx(3.716e-05, rel=1e-3)
    # Fisher's tea: 3 of 4, 1 of 4; fisher.test: p = 0.4857.
    assert exact_tests.fisher([np.array([1.0, 1, 1, 0]), np.array([1.0, 0, 0, 0])]).p == pytest.approx(0.4857, abs=1e-4)


def test_intervals_of_shares_are_newcombes():
    # Newcombe (1998), Statistics in Medicine 17: 81 of 263; 56 of 70 and 48 of 80; pairs 36, 12, 2, 0.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    one, other = np.repeat((1.0, 0.0), (56, 14)), np.repeat((1.0, 0.0), (48, 32))
    assert effects.share_difference(one, other, paired=False) == pytest.approx((0.2, 0.0524, 0.3339), abs=1e-4)
    one, other = np.repeat((1.0, 1, 0, 0), (36, 12, 2, 0)), np.repeat((1.0, 0, 1, 0), (36, 12, 2, 0))
    assert effects.share_difference(one, other, paired=True) == pytest.approx((0.2, 0.0569, 0.3404), abs=1e-4)


def test_power_is_that_of_gpower_and_cohens_tables():
    assert [sensitivity.needed(d, paired=True) for d in (0.2, 0.5, 0.8)] == [199, 34, 15]
    assert [sensitivity.needed(d, paired=False) for d in (0.2, 0.5, 0.8)] == [394, 64, 26]
    # R: power.t.test(n = 34, power = .8, type = "paired")$delta
    assert sensitivity.least_effect(34, None) == pytest.approx(0.4950286, abs=1e-5)
    assert sensitivity.least_effect(2, None) is not None
    assert sensitivity.least_effect(1, None) is None


@given(st.floats(0.05, 2.0), st.integers(2, 60), st.integers(2, 60))
@settings(max_examples=50, deadline=None)
def test_more_participants_and_larger_differences_are_found_more_often(effect: float, one: int, other: int):
    power = sensitivity.t_power(effect, one, other)
    assert sensitivity.LEVEL <= power <= 1
    assert sensitivity.t_power(effect, one + 1, other) >= power - 1e-9
    assert sensitivity.t_power(1.1 * effect, one, other) >= power - 1e-9


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
