"""Strategy "evidence" weighs what explains the assists, and says how sure it is."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.claims import Claims
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.ground_truth import best_mapping
from mbd_mapping.similarity import HUE, SIZE, Comparison
from mbd_mapping.strategy import Pair
from mbd_mapping.synthetic import random_problem, random_table
from mbd_mapping.tables import ObjectTable
from mbd_mapping.teachers import teachers_of

CONFIG = MappingConfig(strategy="evidence")


def problem(seed: int, size: int = 6, config: MappingConfig = CONFIG) -> Comparison:
    """A problem of experiment 1."""
    source, target = random_problem(np.random.default_rng(seed), size)
    return Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), config)


def posterior_by_enumeration(comparison: Comparison, assists: list[Pair]) -> dict[tuple[int, ...], float]:
    """P(m | A) of every mapping of a square problem, summed over all hypotheses one by one."""
    teachers = teachers_of(comparison)
    size = len(comparison.source)
    mappings = np.array(list(itertools.permutations(range(size))))
    claims = Claims.of(assists, size, size, comparison.config)
    prior = np.exp(teachers.log_prior)[:, None] * teachers.weights[:, np.arange(size), mappings].prod(axis=2)
    joint = prior.sum(axis=0) * claims.of_mappings(mappings)
    return dict(zip(map(tuple, mappings.tolist()), joint / joint.sum(), strict=True))


@pytest.mark.parametrize("space", list(FeatureSpace))
@given(seed=st.integers(0, 2**32), noise=st.sampled_from([0.0, 0.02]))
def test_score_is_the_greatest_posterior(space: FeatureSpace, seed: int, noise: float) -> None:
    """The mapping is the most probable of all, and its score that probability, as enumeration finds it."""
    rng = np.random.default_rng(seed)
    config = replace(CONFIG, feature_space=space, similarity_noise=noise)
    comparison = problem(seed, 4, config)
    assists = [(int(rng.integers(4)), int(rng.integers(4))) for _ in range(int(rng.integers(0, 4)))]
    everything = posterior_by_enumeration(comparison, assists)
    found = infer_evidence(comparison, assists, ())
    assert found.score == pytest.approx(everything[found.columns], abs=1e-9)
    if noise == 0.0:
        assert found.score == pytest.approx(max(everything.values()), abs=1e-9)
    assert found.score <= found.confidence + 1e-9


@given(seed=st.integers(0, 2**32))
def test_the_prior_is_a_probability(seed: int) -> None:
    """Before any assist the shares of all mappings sum to 1."""
    comparison = problem(seed, 4)
    teachers = teachers_of(comparison)
    mappings = np.array(list(itertools.permutations(range(4))))
    weight = teachers.weights[:, np.arange(4), mappings].prod(axis=2)
    assert float((np.exp(teachers.log_prior)[:, None] * weight).sum()) == pytest.approx(1.0)


@given(seed=st.integers(0, 2**32))
def test_repeating_an_assist_changes_nothing(seed: int) -> None:
    """The same assist twice is no more evidence than once, and a withdrawn one leaves no trace."""
    comparison = problem(seed)
    once = infer_evidence(comparison, [(0, 3), (2, 1)], (1, 3))
    infer_evidence(comparison, [(0, 3), (2, 1), (1, 5)], (3,))
    assert infer_evidence(comparison, [(0, 3), (2, 1), (0, 3)], (1, 3)) == once


@given(seed=st.integers(0, 2**32))
def test_the_order_of_the_assists_does_not_matter(seed: int) -> None:
    """Evidence is a set: any order gives the same answer."""
    comparison = problem(seed)
    forth = infer_evidence(comparison, [(0, 3), (2, 1), (4, 4)], ())
    back = infer_evidence(comparison, [(4, 4), (2, 1), (0, 3)], ())
    assert back.columns == forth.columns
    assert back.confidence == pytest.approx(forth.confidence)


def test_a_wrong_first_assist_is_not_fatal() -> None:
    """One wrong assist, given first, is outweighed by right ones in nearly every problem; by "mbd" it never is."""
    solved = 0
    for seed in range(40):
        comparison = problem(seed)
        truth = best_mapping(comparison, (HUE,) if seed % 2 else (SIZE,))[1]
        wrong = (0, truth[1])
        found = infer_evidence(comparison, [wrong, *((row, truth[row]) for row in (2, 3, 4, 5))], ())
        solved += found.columns == truth
    assert solved >= 38


def test_assists_that_fit_one_feature_find_the_rest() -> None:
    """Two assists by hue suffice to map the other objects by hue, when nothing else fits them."""
    hits = 0
    for seed in range(40):
        comparison = problem(seed)
        truth = best_mapping(comparison, (HUE,))[1]
        hits += infer_evidence(comparison, [(k, truth[k]) for k in range(2)], ()).columns == truth
    assert hits >= 30


def test_a_tie_is_not_confidence() -> None:
    """Objects that differ in nothing share the probability evenly."""
    table = random_table(np.random.default_rng(0), 1, "s")
    same = ObjectTable(
        ("a", "b", "c"),
        np.repeat(table.hue, 3),
        np.repeat(table.volume, 3),
        np.repeat(table.relations, 3, axis=0),
        table.affordances * 3,
        table.properties * 3,
    )
    found = infer_evidence(Comparison.of(same, same, CONFIG), (), (0, 1, 2))
    assert found.ties == 6
    assert found.confidence == pytest.approx(1 / 6)


def test_the_question_asks_where_the_answers_differ() -> None:
    """The question of greatest gain is one the likely mappings disagree on, and no gain exceeds log2 of the answers."""
    for seed in range(20):
        comparison = problem(seed)
        found = infer_evidence(comparison, (), range(6))
        assert 0.0 <= found.information_gain <= np.log2(6)
        everything = posterior_by_enumeration(comparison, [])
        spread = [max(sum(p for m, p in everything.items() if m[r] == c) for c in range(6)) for r in range(6)]
        assert spread[found.next_row] <= min(spread) + 0.25


def test_a_known_answer_is_not_worth_asking() -> None:
    """Once a row is as good as known, another row is asked about."""
    comparison = problem(3)
    truth = best_mapping(comparison, (HUE,))[1]
    asked = infer_evidence(comparison, [(0, truth[0])], range(6))
    assert asked.next_row != 0
