"""Scenes that do not match one to one: a partial mapping with a confidence, not an exception."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.inference import STRATEGIES, infer
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

strategies = pytest.mark.parametrize("strategy", sorted(STRATEGIES))
HUES = {"red": 5.0, "green": 120.0, "blue": 240.0}


def cups(role: Role, *names: str) -> Scene:
    """Equal cups of these colours, in no relation to each other."""
    return Scene(role, tuple(SceneObject(n, (0.5, 0.0, 0.0), (0.08, 0.08, 0.1), hue=HUES[n]) for n in names))


def task_of(source: Scene, *used: str) -> Task:
    """A task that picks these objects in turn."""
    return Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(used)))


@strategies
def test_a_distractor_is_left_out(strategy: str) -> None:
    """Example: a blue cup nobody demonstrated with stays unmapped."""
    source, target = cups(Role.SOURCE, "red", "green"), cups(Role.TARGET, "blue", "green", "red")
    found = infer(task_of(source, "red", "green"), target, [], MappingConfig(strategy=strategy))
    assert found.mapping.as_dict == {"red": "red", "green": "green"}
    assert found.confidence > 0.0


@strategies
def test_a_missing_object_is_left_out(strategy: str) -> None:
    """Example: nothing in the target scene is like the blue cup, and it stays unmapped."""
    source, target = cups(Role.SOURCE, "red", "green", "blue"), cups(Role.TARGET, "green", "red")
    found = infer(task_of(source, "red", "green", "blue"), target, [], MappingConfig(strategy=strategy))
    assert found.mapping.as_dict == {"red": "red", "green": "green"}
    assert found.confidence > 0.0


@strategies
def test_an_unused_source_object_keeps_its_like_for_itself(strategy: str) -> None:
    """Example: the green cup, which the task never uses, still takes the green one, and is never asked about."""
    source, target = cups(Role.SOURCE, "red", "green", "blue"), cups(Role.TARGET, "blue", "green", "red")
    found = infer(task_of(source, "red", "blue"), target, [], MappingConfig(strategy=strategy))
    assert found.mapping.as_dict == {"red": "red", "green": "green", "blue": "blue"}
    assert found.next_question in {"red", "blue"}
    assisted = [Assist("red", "red"), Assist("blue", "blue")]
    assert infer(task_of(source, "red", "blue"), target, assisted, MappingConfig(strategy=strategy)).next_question == ""


@strategies
def test_several_steps_on_one_object(strategy: str) -> None:
    """Example: placed onto twice, the blue cup is one object with one counterpart, and one assist settles it."""
    source, target = cups(Role.SOURCE, "red", "green", "blue"), cups(Role.TARGET, "blue", "green", "red")
    task = task_of(source, "red", "blue", "green", "blue")
    config = MappingConfig(strategy=strategy)
    once = infer(task, target, [Assist("blue", "green", 1)], config)
    twice = infer(task, target, [Assist("blue", "green", 1), Assist("blue", "green", 3)], config)
    assert twice == replace(once, num_assists=2)
    assert once.next_question in {"red", "green"}


@strategies
@given(seed=st.integers(0, 2**32), n=st.integers(1, 5), m=st.integers(1, 5))
def test_every_size_gives_a_partial_injective_mapping(strategy: str, seed: int, n: int, m: int) -> None:
    """As many objects as possible are mapped, no target twice, and the confidence is a share."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    assists = [Assist(f"s{rng.integers(n)}", f"t{rng.integers(m)}") for _ in range(int(rng.integers(0, 3)))]
    for space in FeatureSpace:
        config = MappingConfig(strategy=strategy, feature_space=space)
        found = infer(task_of(source, *source.ids), target, assists, config)
        assert len(found.mapping.pairs) == len(set(found.mapping.as_dict.values())) == min(n, m)
        assert 0.0 <= found.confidence <= 1.0


@given(seed=st.integers(0, 2**32), n=st.integers(1, 4), m=st.integers(1, 4))
def test_evidence_shares_sum_to_one_over_partial_mappings(seed: int, n: int, m: int) -> None:
    """The score of a partial mapping is its posterior probability among all partial mappings."""
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    config = MappingConfig(strategy="evidence", max_alternatives=1000)
    found = infer(task_of(source, *source.ids), target, [], config)
    scores = [found.mapping.score, *(a.score for a in found.alternatives)]
    assert sum(scores) <= 1.0 + 1e-9
    possible = len(list(itertools.permutations(range(max(n, m)), min(n, m))))
    assert found.mapping.score >= 1.0 / possible - 1e-9
