"""What is no step is told as what it was, and a near tie as doubt."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.segmentation import segment
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task

CLOSE, OPEN = GripperAction.CLOSE, GripperAction.OPEN
BOX = SceneObject("box", (0.5, 0.0, 0.04), (0.06, 0.06, 0.08))
FAR = SceneObject("far", (0.5, 0.4, 0.04), (0.06, 0.06, 0.08))
SCENE = Scene(Role.SOURCE, (BOX, FAR))
Waypoint = tuple[float, float, float, float]


def task_of(way: list[Waypoint], events: list[GripperEvent], scene: Scene = SCENE) -> Task:
    """The task of a tool that goes through (time [s], x, y, z [m])."""
    knots = np.array(way)
    t = np.arange(knots[0, 0], knots[-1, 0], 0.02)
    positions = np.stack([np.interp(t, knots[:, 0], knots[:, k]) for k in (1, 2, 3)], axis=1)
    path = ToolTrajectory.from_samples(t, positions, np.tile([1.0, 0, 0, 0], (t.size, 1)))
    return segment(path, events, scene, stamp=float(t[-1]))


def names(task: Task) -> list[tuple[StepKind, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


def test_a_push_with_the_closed_fist_is_no_pick():
    """The hand closes beside the box and goes through where it stood, without ever rising."""
    way = [(0, 0.4, 0.0, 0.05), (2, 0.46, 0.0, 0.05), (3, 0.46, 0.0, 0.05), (6, 0.7, 0.0, 0.05), (8, 0.7, 0.0, 0.05)]
    task = task_of(way, [GripperEvent(2.5, CLOSE), GripperEvent(7.0, OPEN)])
    assert task.steps == () and "taken as a push" in task.problems[0]


def test_a_push_with_fingers_that_are_shut_though_the_box_is_wide_is_no_pick():
    way = [(0, 0.5, 0.0, 0.07), (3, 0.5, 0.0, 0.07), (6, 0.7, 0.0, 0.07), (8, 0.7, 0.0, 0.07)]
    shut = [GripperEvent(2.5, CLOSE, level=1.0), GripperEvent(7.0, OPEN)]
    assert "taken as a push" in task_of(way, shut).problems[0]
    gripped = [GripperEvent(2.5, CLOSE, level=0.5), GripperEvent(7.0, OPEN)]
    assert names(task_of(way, gripped)) == [(StepKind.PICK, "box"), (StepKind.PLACE, "box")]


HANDED = [(0, 0.5, 0.0, 0.07), (3, 0.5, 0.0, 0.07), (6, 0.4, -0.2, 0.5), (20, 0.4, -0.2, 0.5)]


def test_a_handover_in_the_air_is_no_place():
    task = task_of(HANDED, [GripperEvent(2.5, CLOSE), GripperEvent(7.0, OPEN)])
    assert names(task) == [(StepKind.PICK, "box")]
    assert "handed over in the air" in task.problems[0] and "0.43 m" in task.problems[0]


def test_what_was_handed_over_and_taken_again_is_placed_where_it_then_is_put():
    way = [*HANDED[:3], (10, 0.4, -0.2, 0.5), (14, 0.6, 0.3, 0.07), (20, 0.6, 0.3, 0.07)]
    events = [GripperEvent(2.5, CLOSE), GripperEvent(7.0, OPEN), GripperEvent(8.0, CLOSE), GripperEvent(16.0, OPEN)]
    task = task_of(way, events)
    assert names(task) == [(StepKind.PICK, "box"), (StepKind.PLACE, "box")]


@given(sag=st.floats(0.0, 0.06))
def test_a_sag_of_the_arm_before_a_re_grasp_is_no_step(sag: float):
    low = 0.07 - sag
    way = [(0, 0.5, 0.0, 0.07), (3, 0.5, 0.0, 0.07), (5, 0.5, 0.0, low), (8, 0.5, 0.0, 0.07), (11, 0.5, 0.0, 0.4)]
    way += [(14, 0.5, 0.4, 0.15), (20, 0.5, 0.4, 0.15)]
    events = [GripperEvent(2.5, CLOSE), GripperEvent(6.0, OPEN), GripperEvent(7.8, CLOSE), GripperEvent(16.0, OPEN)]
    task = task_of(way, events)
    assert names(task) == [(StepKind.PICK, "box"), (StepKind.PLACE, "far")]
    assert "re-grasp" in task.problems[0]


def test_between_two_samples_a_slow_recording_takes_the_one_that_was_at_an_object():
    way = [(0, 0.5, 0.0, 0.07), (3, 0.5, 0.0, 0.07), (4, 0.5, 0.2, 0.4), (8, 0.5, 0.2, 0.4)]
    assert task_of(way, [GripperEvent(4.0, CLOSE)]).steps == ()
    assert names(task_of(way, [GripperEvent(4.0, CLOSE, unsure=1.0)])) == [(StepKind.PICK, "box")]


@given(apart=st.floats(0.0, 0.05))
def test_doubt_is_a_half_at_a_tie_falls_with_the_margin_and_is_gone_beyond_noise(apart: float):
    """The tool closes between two boxes, nearer to one by ``apart``."""
    one = SceneObject("one", (0.5, -0.06, 0.04), (0.06, 0.06, 0.08))
    other = SceneObject("other", (0.5, 0.06 + apart, 0.04), (0.06, 0.06, 0.08))
    way = [(0, 0.5, 0.0, 0.07), (3, 0.5, 0.0, 0.07)]
    [step] = task_of(way, [GripperEvent(2.0, CLOSE)], Scene(Role.SOURCE, (one, other))).steps
    assert step.primary_object == "one" or apart < 1e-9
    assert step.doubt == pytest.approx(0.5 * math.erfc(apart / 0.006), abs=1e-6)
    assert (step.doubt > 0.3) == (apart < 0.002) or 0.0019 < apart < 0.0024
    assert step.doubt < 0.01 or apart < 0.011


def test_a_hand_that_closed_a_little_beside_an_object_and_never_rose_is_said_to_may_have_pushed():
    beside = [(0, 0.465, 0.0, 0.05), (3, 0.465, 0.0, 0.05), (6, 0.6, 0.0, 0.05), (8, 0.6, 0.0, 0.05)]
    task = task_of(beside, [GripperEvent(2.5, CLOSE), GripperEvent(7.0, OPEN)])
    assert names(task) == [(StepKind.PICK, "box"), (StepKind.PLACE, "box")]
    [problem] = task.problems
    assert "5 mm beside it and never rose" in problem and "delete the step" in problem
    around = [(t, x + 0.035, y, z) for t, x, y, z in beside]
    assert task_of(around, [GripperEvent(2.5, CLOSE), GripperEvent(7.0, OPEN)]).problems == ()


@pytest.mark.parametrize(("above", "said"), [(0.02, False), (0.1, True)])
def test_what_is_let_go_between_putting_onto_and_handing_over_is_said(above: float, said: bool):
    z = 0.05 + 0.08 + above
    way = [(0, 0.5, 0.0, 0.05), (3, 0.5, 0.0, 0.05), (5, 0.5, 0.0, 0.3), (8, 0.5, 0.4, 0.3), (9, 0.5, 0.4, z)]
    task = task_of([*way, (12, 0.5, 0.4, z)], [GripperEvent(2.5, CLOSE), GripperEvent(10.0, OPEN)])
    assert task.steps[1].primary_object == ("box" if said else "far")
    assert any("0.10 m above what is below it" in problem for problem in task.problems) == said
