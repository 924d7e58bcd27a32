"""The question that would teach most: its gain is that of going through every mapping and every answer."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_experiments.simulated_problems.ground_truth import best_mapping
from mbd_mapping.config import MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.question import best_question
from mbd_mapping.similarity import HUE, Comparison
from mbd_mapping.strategy import UNMAPPED, Pair, QuestionAnswers
from mbd_mapping.synthetic import random_problem, random_table
from mbd_mapping.tables import ObjectTable
from mbd_mapping.teachers.assist_likelihood import AssistLikelihood
from mbd_mapping.teachers.hypotheses import hypotheses_of
from mbd_model.estimate import QuestionKind

# No assist is doubted, so that the question is always about a step.
CONFIG = MappingConfig(strategy="evidence", question_kinds=(QuestionKind.WHAT_NEXT,), doubt_at=1.0)


def entropy(shares: np.ndarray) -> float:
    """Of a distribution [bit]."""
    return float(-sum(p * np.log2(p) for p in shares if p > 0))


def gains_by_enumeration(comparison: Comparison, assists: list[Pair]) -> list[float]:
    """For each row: entropy of the mapping now, less what is expected to be left of it after the answer [bit].

    Every hypothesis, mapping and answer is gone through; square problems only.
    """
    size = len(comparison.source)
    hypotheses, error = hypotheses_of(comparison), comparison.config.assist_error
    mappings = np.array(list(itertools.permutations(range(size))))
    prior = np.exp(hypotheses.log_prior)[:, None] * hypotheses.weights[:, np.arange(size), mappings].prod(axis=2)
    joint = prior.sum(axis=0) * AssistLikelihood.of(assists, size, size, comparison.config).of_mappings(mappings)
    posterior = joint / joint.sum()
    gains = []
    for row in range(size):
        left = 0.0
        for answer in range(size):
            answered = posterior * np.where(mappings[:, row] == answer, 1.0 - error, error / (size - 1))
            left += answered.sum() * entropy(answered / answered.sum())
        gains.append(entropy(posterior) - left)
    return gains


@given(seed=st.integers(0, 2**32), count=st.integers(0, 4), noise=st.sampled_from([0.0, 0.02]), alike=st.integers(0, 2))
def test_the_gain_is_that_of_enumeration(seed: int, count: int, noise: float, alike: int) -> None:
    """Whatever the scenes and assists, ties, exchanged and contradicting ones included."""
    rng = np.random.default_rng(seed)
    config = replace(CONFIG, similarity_noise=noise)
    comparison = Comparison.of(random_table(rng, 4, "s", alike), random_table(rng, 4, "t", alike), config)
    assists = [(int(rng.integers(4)), int(rng.integers(4))) for _ in range(count)]
    if rng.random() < 0.5:
        assists = list(enumerate(rng.permutation(4).tolist()))[:count]
    gains = gains_by_enumeration(comparison, assists)
    for row in range(4):
        assert infer_evidence(comparison, assists, (row,)).information_gain == pytest.approx(gains[row], abs=1e-6)
    found = infer_evidence(comparison, assists, range(4))
    assert found.information_gain == pytest.approx(max(gains), abs=1e-6)
    assert gains[found.next_row] == pytest.approx(max(gains), abs=1e-6)


def test_a_known_answer_is_not_worth_asking() -> None:
    """Once a row is as good as known, another row is asked about."""
    source, target = random_problem(np.random.default_rng(3), 6)
    comparison = Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), CONFIG)
    truth = best_mapping(comparison, (HUE,))[1]
    assert infer_evidence(comparison, [(0, truth[0])], range(6)).next_row != 0


def test_with_nothing_left_to_ask_there_is_no_question() -> None:
    """No step without an assist: no question and no gain."""
    source, target = random_problem(np.random.default_rng(3), 4)
    comparison = Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), CONFIG)
    found = infer_evidence(comparison, [], ())
    assert (found.next_row, found.information_gain) == (UNMAPPED, 0.0)


EVERY = replace(CONFIG, question_kinds=MappingConfig().question_kinds)


def test_an_even_choice_between_two_is_put_as_one() -> None:
    """Of two equally likely targets the teacher is asked which it is, or whether it is one: that costs less."""
    share = np.array([[0.49, 0.49, 0.01, 0.01], [0.01, 0.01, 0.49, 0.49]])
    found = best_question(share, (0, 1), EVERY)
    assert found.kind != QuestionKind.WHAT_NEXT
    assert found.row == 0
    assert set(found.columns) <= {0, 1}


def test_where_anything_is_possible_the_question_is_open() -> None:
    """Of many equally likely targets a yes or no would say next to nothing."""
    found = best_question(np.full((8, 8), 1.0 / 8), range(8), EVERY)
    assert (found.kind, found.columns) == (QuestionKind.WHAT_NEXT, ())


@given(seed=st.integers(0, 2**32), cost=st.floats(1.0, 30.0))
def test_no_other_kind_would_teach_more_a_second(seed: int, cost: float) -> None:
    """Whatever the costs, the question chosen has the greatest gain for its time of each kind asked alone."""
    share = np.random.default_rng(seed).dirichlet(np.ones(5), 4)
    config = replace(EVERY, open_cost=cost)
    found = best_question(share, range(4), config)
    for kind in config.question_kinds:
        alone = best_question(share, range(4), replace(config, question_kinds=(kind,)))
        assert alone.kind == kind
        assert found.rate >= alone.rate - 1e-8
    assert 0.0 <= found.gain <= np.log2(5) + 1e-9


def test_a_no_is_evidence_too() -> None:
    """Told that it is not t1, the robot believes it less, and everything else of that row more."""
    source, target = random_problem(np.random.default_rng(3), 5)
    comparison = Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), CONFIG)
    likely = infer_evidence(comparison, [], ()).columns[0]
    after = infer_evidence(comparison, [], (), QuestionAnswers(denied=((0, likely),)))
    assert after.columns[0] != likely
