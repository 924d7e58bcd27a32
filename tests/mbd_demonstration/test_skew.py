"""Clocks of gripper and tool that differ, and words said late or early, are told from the tool's motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.clocks.skew import find_skew, shifted
from mbd_demonstration.clocks.words import words_dated
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.segmentation import segment
from mbd_demonstration.synthetic import Demonstration, Sensing, demonstrate, random_moves, random_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_model.geometry.boxes import nearest


def shown(seed: int, moves: int = 4, **sensing: float) -> tuple[Demonstration, ToolTrajectory]:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    made = demonstrate(scene, random_moves(rng, scene, moves), Sensing(**sensing), rng)
    return made, ToolTrajectory.from_samples(made.stamps, made.positions, made.quaternions)


@given(seed=st.integers(0, 2**32), rate=st.floats(8, 100), moves=st.integers(1, 5))
def test_clocks_that_agree_are_left_alone(seed, rate, moves):
    made, path = shown(seed, moves, rate=rate)
    assert find_skew(path, made.events).by is None


@given(seed=st.integers(0, 2**32), rate=st.floats(8, 100), skew=st.floats(1.0, 5.0), ahead=st.booleans())
def test_a_skew_of_seconds_is_mended_by_what_it_is_or_left(seed, rate, skew, ahead):
    made, path = shown(seed, 4, rate=rate)
    skew = -skew if ahead else skew
    found = find_skew(path, shifted(made.events, -skew)).by
    assert found is None or found == pytest.approx(skew, abs=0.6)


def test_most_skews_of_three_seconds_are_found():
    found = [find_skew(path, shifted(made.events, -3.0)).by for made, path in (shown(seed, 5) for seed in range(20))]
    assert sum(skew is not None for skew in found) >= 15


@given(seed=st.integers(0, 2**32), off=st.lists(st.floats(-0.8, 0.8), min_size=8, max_size=8))
def test_words_a_little_late_or_early_give_the_same_steps(seed, off):
    made, path = shown(seed, 4, ramp=1.0)
    words = [GripperEvent(e.stamp + d, e.action) for e, d in zip(made.events, off, strict=True)]

    def near(stamp: float) -> bool:
        return nearest(path.pose_at(stamp).position, made.scene.objects)[0][0] <= 0.08

    dated, _ = words_dated(words, path, near_object=near)
    task = segment(path, dated, made.scene, stamp=1.0)
    assert tuple((s.kind, s.primary_object) for s in task.steps) == made.steps


@given(seed=st.integers(0, 2**32), off=st.lists(st.floats(-1.9, 1.9), min_size=8, max_size=8))
def test_words_said_while_the_tool_moves_are_dated_by_the_fingers(seed, off):
    made, path = shown(seed, 4)
    words = [GripperEvent(e.stamp + d, e.action) for e, d in zip(made.events, off, strict=True)]
    dated, notes = words_dated(words, path, made.events)
    moved = [abs(d.stamp - w.stamp) for d, w in zip(dated, words, strict=True)]
    assert len(notes) == sum(by > 0.3 for by in moved)
    for word, event, found in zip(words, made.events, dated, strict=True):
        moving = path.farthest_from(path.pose_at(word.stamp).position, word.stamp - 0.1, word.stamp + 0.1) > 0.02
        assert not moving or found.stamp == pytest.approx(event.stamp)


def test_a_word_far_from_any_rest_stays_where_it_was_said():
    t = np.arange(0.0, 20.0, 0.05)
    path = ToolTrajectory.from_samples(
        t, np.stack([0.1 * t, 0 * t, 0 * t], axis=1), np.tile([1.0, 0, 0, 0], (t.size, 1))
    )
    word = GripperEvent(10.0, GripperAction.CLOSE)
    assert words_dated([word], path) == ((word,), ())
