"""A recording that was cut off is kept, and what nobody saw meanwhile is asked for again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.interruption import SAME, cut_off_notes, gaps, received_before
from mbd_demonstration.segmentation import segment
from mbd_demonstration.synthetic import Move, Sensing, demonstrate, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.errors import MbdError
from mbd_model.task import Task

BEGIN = 100.0


def recorded() -> tuple[Task, np.ndarray, list[GripperEvent]]:
    scene = random_scene(np.random.default_rng(3), 3)
    shown = demonstrate(scene, (Move("s1", onto="s2"),), Sensing(rate=10.0), np.random.default_rng(3), begin=BEGIN)
    path = ToolTrajectory.from_samples(shown.stamps, shown.positions, shown.quaternions)
    return segment(path, shown.events, scene, stamp=1.0), shown.stamps, list(shown.events)


TASK, STAMPS, EVENTS = recorded()


@given(cut=st.floats(float(STAMPS[0]), float(STAMPS[-1]) - 0.5), length=st.floats(0.2, 5.0))
def test_it_is_asked_for_again_exactly_if_the_hand_acted_where_nobody_saw_it(cut: float, length: float):
    seen = STAMPS[(cut >= STAMPS) | (cut + length < STAMPS)]
    (gap,) = gaps([float(seen[seen <= cut].max())], seen)
    acted = any(gap[0] < e.stamp < gap[1] for e in EVENTS)
    if acted:
        with pytest.raises(MbdError, match=r"the recording was cut off .*show the task again"):
            cut_off_notes(TASK, BEGIN, [gap], EVENTS)
    else:
        (note,) = cut_off_notes(TASK, BEGIN, [gap], EVENTS)
        assert f"from {gap[0] - BEGIN:.1f} s" in note or gap[1] == np.inf


def test_what_the_fingers_show_counts_as_much_as_what_was_said():
    end = TASK.steps[0].end
    with pytest.raises(MbdError, match="the hand closed meanwhile"):
        cut_off_notes(TASK, BEGIN, [(end - 0.5, end + 0.5)], [])
    nowhere = replace(TASK, steps=TASK.steps[1:])
    assert len(cut_off_notes(nowhere, BEGIN, [(end - 0.5, end + 0.5)], [])) == 1


def test_a_recording_that_was_not_cut_off_has_nothing_to_be_said():
    assert cut_off_notes(TASK, BEGIN, gaps([], STAMPS), EVENTS) == ()


def test_one_command_that_came_by_two_ways_is_one():
    event = GripperEvent(5.0, GripperAction.CLOSE)
    assert received_before([event], replace(event, stamp=5.0 + SAME))
    assert not received_before([event], replace(event, stamp=5.5))
    assert not received_before([event], GripperEvent(5.0, GripperAction.OPEN))
