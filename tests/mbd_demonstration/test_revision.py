"""The last step can be taken back and shown again, and the objects stay followed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.revision.resuming import redo_from, resume, without_last_step
from mbd_demonstration.segmentation import segment
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_moves, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.task import StepKind, Task


def path_of(shown: Demonstration) -> ToolTrajectory:
    return ToolTrajectory.from_samples(shown.stamps, shown.positions, shown.quaternions)


def names(task: Task) -> list[tuple[StepKind, str]]:
    return [(s.kind, s.primary_object) for s in task.steps]


@given(seed=st.integers(0, 2**32), cut=st.integers(0, 4))
def test_a_demonstration_in_two_parts_shows_what_it_shows_in_one(seed: int, cut: int):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    shown = demonstrate(scene, random_moves(rng, scene, 4), Sensing(), rng)
    path, events = path_of(shown), shown.events
    complete = segment(path, events, scene, stamp=1.0)
    first = segment(path, events[: 2 * cut], scene, stamp=1.0)
    both = segment(path, events[2 * cut :], scene, stamp=1.0, so_far=resume(first) if first.steps else None)
    assert names(both) == names(complete) == list(shown.steps)
    np.testing.assert_allclose([s.offset for s in both.steps], [s.offset for s in complete.steps], atol=1e-9)


@given(seed=st.integers(0, 2**32))
def test_a_place_shown_again_replaces_the_dropped_one(seed: int):
    """The object is taken again from where the dropped place left it; that is no new pick."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    moves = random_moves(rng, scene, 2)
    shown = demonstrate(scene, moves, Sensing(), rng)
    first = segment(path_of(shown), shown.events, scene, stamp=1.0)
    now = Scene(Role.SOURCE, shown.after)
    elsewhere = demonstrate(now, (Move(moves[-1].object_id, place=(0.35, 0.5)),), Sensing(), rng, begin=1000.0)
    again = segment(path_of(elsewhere), elsewhere.events, scene, stamp=3.0, so_far=redo_from(first))
    assert names(again) == [*shown.steps[:-1], (StepKind.PLACE, moves[-1].object_id)]
    assert not any("holding" in p or "never placed" in p for p in again.problems)


@given(seed=st.integers(0, 2**32))
def test_a_pick_dropped_and_shown_again_is_counted_once(seed: int):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    shown = demonstrate(scene, random_moves(rng, scene, 2), Sensing(), rng)
    ended_holding = segment(path_of(shown), shown.events[:3], scene, stamp=1.0)
    kept = without_last_step(ended_holding, 2.0)
    again = segment(path_of(shown), shown.events[2:], scene, stamp=3.0, so_far=resume(kept))
    assert names(again) == list(shown.steps)


@given(seed=st.integers(0, 2**32), words=st.text(max_size=9))
def test_what_a_recording_left_open_is_forgotten_when_it_goes_on_whatever_its_words(seed: int, words: str):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    shown = demonstrate(scene, random_moves(rng, scene, 2), Sensing(), rng)
    held = segment(path_of(shown), shown.events[:3], scene, stamp=1.0)
    assert len(held.open_ends) == 1
    reworded = dataclasses.replace(held, problems=(words,) * len(held.problems))
    assert len(resume(reworded).problems) == len(held.problems) - 1
    assert segment(path_of(shown), shown.events[2:], scene, stamp=3.0, so_far=resume(reworded)).open_ends == ()


def test_a_task_without_steps_has_none_to_drop():
    scene = random_scene(np.random.default_rng(0), 2)
    with pytest.raises(MbdError, match="no step to drop"):
        without_last_step(Task(scene, ()), 1.0)
