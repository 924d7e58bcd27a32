"""Means, intervals, tests and power are those of R, scipy and the literature."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_study.analysis import effects, exact_tests, sensitivity
from mbd_study.analysis.choosing import choose_test, welch
from mbd_study.analysis.comparing import overall_rows, pair_rows
from mbd_study.analysis.describing import wilson_interval
from mbd_study.analysis.mixed_model import fit_mixed_model
from published_numbers import DISTANCES, DRUG_1, DRUG_2, FIRST, GIRLS, ROUNDING, SECOND, SPRAYS, groups, measured
from scipy import stats


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
