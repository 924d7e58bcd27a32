"""The steps of a demonstration are what its teacher did, however it was recorded."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.segmentation import BEGAN_CLOSED, NEVER_CLOSED, segment
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_moves, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task

CUPS = Scene(
    Role.SOURCE,
    tuple(SceneObject(f"s{k}", (0.5, 0.2 - 0.2 * k, 0.05), (0.06, 0.06, 0.1)) for k in range(4)),
)


def path_of(shown: Demonstration) -> ToolTrajectory:
    return ToolTrajectory.from_samples(shown.stamps, shown.positions, shown.quaternions)


def understood(shown: Demonstration, events: tuple[GripperEvent, ...] | None = None) -> Task:
    return segment(path_of(shown), shown.events if events is None else events, shown.scene, stamp=99.0)


def show(*moves: Move, seed: int = 0) -> Demonstration:
    return demonstrate(CUPS, moves, Sensing(), np.random.default_rng(seed))


def names(task: Task) -> list[tuple[StepKind, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


RECORDERS = st.builds(
    Sensing,
    rate=st.floats(5, 100),
    position_std=st.floats(0, 0.004),
    dropout=st.floats(0, 0.3),
    shuffle=st.floats(0, 0.3),
)


@given(seed=st.integers(0, 2**32), n=st.integers(2, 7), moves=st.integers(1, 5), recorder=RECORDERS)
def test_generated_demonstrations_give_their_steps(seed, n, moves, recorder):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, n)
    shown = demonstrate(scene, random_moves(rng, scene, moves), recorder, rng)
    # Where several samples in a row are lost no code knows where the tool was; that is reported, and tested below.
    assume(all(path_of(shown).gap_at(e.stamp) < StepSegmentationConfig().max_pose_gap for e in shown.events))
    task = understood(shown)
    assert tuple(names(task)) == shown.steps
    assert task.problems == ()
    assert [s.index for s in task.steps] == list(range(2 * moves))
    assert all(a.end == b.start for a, b in zip(task.steps, task.steps[1:], strict=False))


@given(seed=st.integers(0, 2**32))
def test_renaming_the_objects_renames_the_steps(seed):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    shown = demonstrate(scene, random_moves(rng, scene, 3), Sensing(), rng)
    new = {i: f"x{k}" for k, i in enumerate(scene.ids)}
    renamed = Scene(
        Role.SOURCE, tuple(dataclasses.replace(o, object_id=new[o.object_id]) for o in reversed(scene.objects))
    )
    task = understood(dataclasses.replace(shown, scene=renamed))
    assert names(task) == [(kind, new[i]) for kind, i in shown.steps]


def test_an_object_moved_earlier_is_found_where_it_now_is():
    """Section 6.5.1 of the paper: s1 goes to a free place, then s2 onto s1 there."""
    task = understood(show(Move("s1", place=(0.3, -0.2)), Move("s2", onto="s1")))
    assert names(task)[-1] == (StepKind.PLACE, "s1")
    assert task.steps[-1].tool_position[0] == pytest.approx(0.3, abs=0.02)


def test_an_object_put_beside_another_is_its_own_primary_object():
    beside = CUPS["s0"].centroid
    task = understood(show(Move("s2", place=(beside[0] + 0.07, beside[1]))))
    assert names(task) == [(StepKind.PICK, "s2"), (StepKind.PLACE, "s2")]
    assert task.steps[1].runner_up == "s0"


def test_the_top_of_a_stack_is_what_the_next_object_is_put_onto():
    task = understood(show(Move("s1", onto="s0"), Move("s2", onto="s1"), Move("s3", onto="s2")))
    assert [i for kind, i in names(task) if kind is StepKind.PLACE] == ["s0", "s1", "s2"]


def test_a_long_flat_object_is_nearer_by_its_surface_than_by_its_centroid():
    tray = SceneObject("tray", (0.5, 0.0, 0.01), (0.4, 0.1, 0.02))
    cup = SceneObject("cup", (0.5, 0.30, 0.05), (0.06, 0.06, 0.1))
    scene = Scene(Role.SOURCE, (tray, cup))
    t = np.arange(0.0, 2.0, 0.05)
    path = ToolTrajectory.from_samples(t, np.tile([0.5, 0.19, 0.02], (t.size, 1)), np.tile([1.0, 0, 0, 0], (t.size, 1)))
    task = segment(path, [GripperEvent(1.0, GripperAction.CLOSE)], scene, stamp=2.0)
    assert task.steps[0].primary_object == "tray"
    assert task.steps[0].distance < task.steps[0].runner_up_distance == pytest.approx(0.08)


def test_each_step_keeps_the_tool_relative_to_its_primary_object():
    task = understood(show(Move("s1", onto="s0")))
    for step, obj in zip(task.steps, ("s1", "s0"), strict=True):
        expected = np.array(step.tool_position) - np.array(CUPS[obj].centroid)
        np.testing.assert_allclose(step.offset, expected, atol=1e-12)


def test_a_gripper_that_never_closes_is_reported():
    task = understood(show(Move("s1", onto="s0")), events=())
    assert task.steps == () and task.problems == (NEVER_CLOSED,)


def test_opening_twice_is_reported_and_is_no_step():
    shown = show(Move("s1", onto="s0"))
    last = shown.events[-1].stamp
    task = understood(shown, (*shown.events, GripperEvent(last + 0.3, GripperAction.OPEN)))
    assert names(task) == list(shown.steps)
    assert "opened twice" in task.problems[0]


def test_closing_twice_is_reported_and_is_no_step():
    shown = show(Move("s1", onto="s0"))
    task = understood(shown, (*shown.events, GripperEvent(shown.events[0].stamp + 0.3, GripperAction.CLOSE)))
    assert names(task) == list(shown.steps)
    assert "closed twice" in task.problems[0]


def test_closing_on_nothing_names_the_nearest_object_and_is_no_step():
    shown = show(Move("s1", onto="s0"))
    far = (GripperEvent(0.1, GripperAction.CLOSE), GripperEvent(0.4, GripperAction.OPEN))
    task = understood(shown, far + shown.events)
    assert names(task) == list(shown.steps)
    assert len(task.problems) == 1 and "closed on nothing" in task.problems[0] and " m away" in task.problems[0]


def test_beginning_with_the_gripper_closed_is_reported_and_its_opening_is_no_step():
    shown = show(Move("s1", onto="s0"), Move("s2", onto="s3"))
    task = segment(path_of(shown), shown.events[1:], shown.scene, stamp=99.0, started_closed=True)
    assert names(task) == list(shown.steps[2:])
    assert task.problems == (BEGAN_CLOSED,)


def test_ending_while_holding_is_reported():
    shown = show(Move("s1", onto="s0"))
    task = understood(shown, shown.events[:1])
    assert names(task) == [(StepKind.PICK, "s1")]
    assert "ended while holding 's1'" in task.problems[0]


def test_a_grasp_tried_twice_is_one_pick():
    shown = show(Move("s1", onto="s0"))
    at = shown.events[0].stamp
    again = (GripperEvent(at + 0.1, GripperAction.OPEN), GripperEvent(at + 0.2, GripperAction.CLOSE))
    task = understood(shown, shown.events + again)
    assert names(task) == list(shown.steps)
    assert "re-grasp" in task.problems[0]
    assert task.steps[0].end == at + 0.2


def test_an_event_without_tool_poses_is_reported_and_is_no_step():
    shown = show(Move("s1", onto="s0"), Move("s2", onto="s3"))
    hidden = (shown.stamps < shown.events[2].stamp - 2) | (shown.stamps > shown.events[2].stamp + 2)
    path = ToolTrajectory.from_samples(shown.stamps[hidden], shown.positions[hidden], shown.quaternions[hidden])
    task = segment(path, shown.events, shown.scene, stamp=0.0)
    assert names(task) == list(shown.steps[:2])
    assert any("nearest tool pose" in p for p in task.problems)


def test_a_single_object_has_no_runner_up():
    scene = Scene(Role.SOURCE, (CUPS["s0"],))
    shown = demonstrate(scene, (Move("s0", place=(0.3, 0.0)),), Sensing(), np.random.default_rng(0))
    assert {(s.runner_up, s.runner_up_distance) for s in understood(shown).steps} == {("", math.inf)}
