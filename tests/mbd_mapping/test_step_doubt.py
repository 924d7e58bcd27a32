"""An assist for a demonstrated step in doubt weighs by that doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.strategy import QuestionAnswers
from mbd_mapping.synthetic import random_scene
from mbd_mapping.teachers.assist_likelihood import AssistLikelihood
from mbd_model.assists import Assist
from mbd_model.estimate import MappingEstimate
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

CONFIG = MappingConfig(strategy="evidence")
DOUBTS = st.floats(0.0, 0.5)


def task_in_doubt(source: Scene, doubt: float) -> Task:
    """Every object is picked once; the first may have been the second."""
    steps = tuple(TaskStep(k, StepKind.PICK, i, 0.0) for k, i in enumerate(source.ids))
    first = replace(steps[0], runner_up=source.ids[1], runner_up_distance=0.002, doubt=doubt)
    return Task(source, (first, *steps[1:]))


@given(doubt=DOUBTS, row=st.integers(0, 3), column=st.integers(0, 3))
def test_what_an_assist_may_have_said_sums_to_one_whatever_the_doubt(doubt: float, row: int, column: int):
    """Over all targets the teacher could have named for that step."""
    told = [
        AssistLikelihood.of([(row, c)], 4, 4, CONFIG, QuestionAnswers(doubts=(((row, c), doubt),))).likelihood
        for c in range(4)
    ]
    assert sum(t[row, column] for t in told) == pytest.approx(1.0)


@given(doubt=DOUBTS)
def test_the_odds_of_an_assist_fall_from_those_of_a_sure_one_to_none_as_the_doubt_grows(doubt: float):
    def odds(doubt: float) -> float:
        answers = QuestionAnswers(doubts=(((0, 2), doubt),))
        likelihood = AssistLikelihood.of([(0, 2)], 4, 4, CONFIG, answers).likelihood
        return float(likelihood[0, 2] / likelihood[0, 1])

    sure, chance = odds(0.0), odds((0.75 - CONFIG.assist_error) / (1.0 - CONFIG.assist_error))
    assert sure == pytest.approx((1.0 - CONFIG.assist_error) / (CONFIG.assist_error / 3))
    assert chance == pytest.approx(1.0)
    assert chance <= odds(doubt) <= sure
    assert odds(min(0.5, doubt + 0.01)) <= odds(doubt)


def against_color(doubt: float, *, confirmed: bool = False) -> MappingEstimate:
    """Cups of four colours on both tables; told of the red one, as its only assist, that it is the green one."""

    def row(role: Role, prefix: str) -> Scene:
        hues = (0.0, 90.0, 180.0, 270.0)
        cups = (SceneObject(f"{prefix}{k}", (0.4, 0.2 * k, 0.05), (0.06, 0.06, 0.1), hue=h) for k, h in enumerate(hues))
        return Scene(role, tuple(cups))

    assists = [Assist("s0", "t1", 0, confirmed=confirmed), Assist("s2", "t2", 2), Assist("s3", "t3", 3)]
    return infer(task_in_doubt(row(Role.SOURCE, "s"), doubt), row(Role.TARGET, "t"), assists, CONFIG)


def test_an_assist_for_a_step_in_doubt_gives_way_sooner_to_what_all_else_says():
    sure, doubtful = against_color(0.0), against_color(0.4)
    assert doubtful.best_guess.as_dict["s0"] == "t0"

    def told(estimate: MappingEstimate) -> float:
        return sum(m.score for m in (estimate.mapping, *estimate.alternatives) if m.as_dict.get("s0") == "t1")

    assert told(doubtful) < told(sure)


def test_a_confirmed_assist_is_certain_whatever_its_step_was_about():
    assert against_color(0.4, confirmed=True) == against_color(0.0, confirmed=True)


@given(seed=st.integers(0, 2**32))
def test_without_a_doubt_nothing_changes_and_with_one_it_is_said(seed: int):
    rng = np.random.default_rng(seed)
    source, target = random_scene(rng, Role.SOURCE, 4, "s"), random_scene(rng, Role.TARGET, 4, "t")
    assists = [Assist("s0", "t1", 0)]
    sure = infer(task_in_doubt(source, 0.0), target, assists, CONFIG)
    doubtful = infer(task_in_doubt(source, 0.32), target, assists, CONFIG)
    assert not sure.warnings
    assert doubtful.warnings == ("step 1 may have been about s1 instead of s0 (32%): the assist for it counts less",)
    assert infer(task_in_doubt(source, 0.32), target, [], CONFIG) == infer(
        task_in_doubt(source, 0.0), target, [], CONFIG
    )
    rule = MappingConfig(strategy="mbd")
    told = infer(task_in_doubt(source, 0.32), target, assists, rule)
    assert replace(told, warnings=()) == infer(task_in_doubt(source, 0.0), target, assists, rule)
    assert "counts in full" in told.warnings[0]
