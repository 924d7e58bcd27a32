"""Scenes that do not match one to one: a partial mapping with a confidence, not an exception."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_experiments.public_study.examples import cups, distractor, missing, shared, task_over, unused
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.inference import STRATEGIES, infer
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist
from mbd_model.objects import Role, Scene

strategies = pytest.mark.parametrize("strategy", sorted(STRATEGIES))


@strategies
def test_a_distractor_is_left_out(strategy: str) -> None:
    """A blue cup nobody demonstrated with stays unmapped."""
    example = distractor()
    found = infer(example.task, example.target, [], MappingConfig(strategy=strategy))
    assert found.mapping.as_dict == {"red": "red", "green": "green"}
    assert found.confidence > 0.0


@strategies
def test_a_missing_object_is_left_out(strategy: str) -> None:
    """Nothing in the target scene is like the blue cup, and it stays unmapped."""
    example = missing()
    found = infer(example.task, example.target, [], MappingConfig(strategy=strategy))
    assert found.mapping.as_dict == {"red": "red", "green": "green"}
    assert found.confidence > 0.0


@strategies
def test_an_unused_source_object_keeps_its_like_for_itself(strategy: str) -> None:
    """The green cup, which the task never uses, still takes the green one, and is never asked about."""
    example, config = unused(), MappingConfig(strategy=strategy)
    found = infer(example.task, example.target, [], config)
    assert found.mapping.as_dict == {"red": "red", "green": "green", "blue": "blue"}
    assert found.confidence > 0.0
    assert found.next_question in {"red", "blue"}
    assisted = [Assist("red", "red"), Assist("blue", "blue")]
    assert infer(example.task, example.target, assisted, config).next_question == ""


@strategies
def test_several_steps_on_one_object(strategy: str) -> None:
    """Placed onto twice, the blue cup is one object with one counterpart, and one assist settles it."""
    example, config = shared(), MappingConfig(strategy=strategy)
    once = infer(example.task, example.target, [Assist("blue", "green", 1)], config)
    twice = infer(example.task, example.target, [Assist("blue", "green", 1), Assist("blue", "green", 3)], config)
    assert twice == replace(once, num_assists=2)
    assert once.confidence > 0.0
    assert once.next_question in {"red", "green"}


@strategies
def test_many_distractors_tie_as_often_as_they_are(strategy: str) -> None:
    """Of four equal cups any may play the one cup's role: four mappings tie, however many objects stay unmapped."""
    cup = cups(Role.TARGET, "red").objects[0]
    target = Scene(Role.TARGET, tuple(replace(cup, object_id=f"cup{k}") for k in range(4)))
    found = infer(task_over(cups(Role.SOURCE, "red"), "red"), target, [], MappingConfig(strategy=strategy))
    assert found.ties == 4
    if strategy == "evidence":
        assert found.mapping.score == pytest.approx(0.25)


@strategies
@settings(max_examples=12)
@given(seed=st.integers(0, 2**32), n=st.integers(1, 5), m=st.integers(1, 5))
def test_every_size_gives_a_partial_injective_mapping(strategy: str, seed: int, n: int, m: int) -> None:
    """As many objects as possible are mapped, no target twice, and the confidence is a share."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    assists = [Assist(f"s{rng.integers(n)}", f"t{rng.integers(m)}") for _ in range(int(rng.integers(0, 3)))]
    for space in FeatureSpace:
        config = MappingConfig(strategy=strategy, feature_space=space)
        found = infer(task_over(source, *source.ids), target, assists, config)
        assert len(found.mapping.pairs) == len(set(found.mapping.as_dict.values())) == min(n, m)
        assert 0.0 <= found.confidence <= 1.0


@given(seed=st.integers(0, 2**32), n=st.integers(1, 4), m=st.integers(1, 4))
def test_evidence_shares_sum_to_one_over_partial_mappings(seed: int, n: int, m: int) -> None:
    """The score of a partial mapping is its posterior probability among all partial mappings."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    config = MappingConfig(strategy="evidence", max_alternatives=1000)
    found = infer(task_over(source, *source.ids), target, [], config)
    scores = [found.mapping.score, *(a.score for a in found.alternatives)]
    assert sum(scores) <= 1.0 + 1e-9
    possible = len(list(itertools.permutations(range(max(n, m)), min(n, m))))
    assert found.mapping.score >= 1.0 / possible - 1e-9
