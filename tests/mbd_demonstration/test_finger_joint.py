"""Openings and closings are read off a finger joint, whatever hand and however noisy."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperAction
from mbd_demonstration.synthetic import Sensing, demonstrate, random_moves, random_scene
from mbd_model.errors import MbdError

RECORDERS = st.builds(
    Sensing,
    rate=st.floats(5, 100),
    joint_std=st.floats(0, 0.03),
    dropout=st.just(0.0) | st.floats(0, 0.2),
    shuffle=st.floats(0, 0.3),
    polarity=st.sampled_from(Polarity),
    travel=st.sampled_from([0.012, 0.08, 0.8, 1.3, 100.0, 255.0, 6800.0]),  # m, rad, percent, byte, ticks
    half_closings=st.integers(0, 2),
    half_rest=st.floats(0, 0.1),
    ramp=st.floats(0.3, 3.0),
    drift=st.floats(-0.03, 0.03),
    quantum=st.sampled_from([0.0, 1 / 255, 0.02]),
)


@given(seed=st.integers(0, 2**32), recorder=RECORDERS, glitch=st.floats(0, 0.02))
def test_events_of_generated_demonstrations_are_found(seed, recorder, glitch):
    # Wild samples that a low rate or lost neighbours make as long as a word no code can distinguish from one.
    wild = recorder.rate > 40 and recorder.dropout == 0.0
    recorder = dataclasses.replace(recorder, glitch=glitch if wild else 0.0)
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 5)
    shown = demonstrate(scene, random_moves(rng, scene, 3), recorder, rng)
    found = read_gripper(shown.stamps, shown.joint, FingerJointConfig(polarity=recorder.polarity)).events
    assert [e.action for e in found] == [e.action for e in shown.events]
    off = [abs(f.stamp - e.stamp) for f, e in zip(found, shown.events, strict=True)]
    # Fingers are told from rest within noise, steps and drift of the joint: that is a share of their way, and its time.
    unsure = 4.0 * (recorder.joint_std + recorder.quantum) + 2.0 * abs(recorder.drift)
    assert max(off) <= unsure * recorder.ramp + 0.15 + 2.0 * np.diff(np.unique(shown.stamps)).max()


@given(seed=st.integers(0, 2**32), rate=st.floats(5, 100), cuts=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_a_recording_may_begin_closed_and_end_as_the_hand_comes_to_rest(seed, rate, cuts):
    """Any stretch of a recording shows the events that lie in it, also when it is stopped right after the last one."""
    recorder = Sensing(rate=rate, ramp=0.5)
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    shown = demonstrate(scene, random_moves(rng, scene, 3), recorder, rng)
    resting = 3.0 / rate  # the fingers rest that long after their motion
    stamps = [e.stamp + (recorder.ramp if e.action is GripperAction.OPEN else 0.0) for e in shown.events]
    first = round(cuts[0] * 4)
    last = first + 1 + round(cuts[1] * (4 - first))
    begin = stamps[first - 1] + resting if first else float(shown.stamps[0])
    kept = (shown.stamps >= begin) & (shown.stamps <= stamps[last] + resting)
    reading = read_gripper(shown.stamps[kept], shown.joint[kept])
    assert [e.action for e in reading.events] == [e.action for e in shown.events[first : last + 1]]
    assert reading.started_closed == (first % 2 == 1)


@given(seed=st.integers(0, 2**32), scale=st.floats(1e-2, 1e3), shift=st.floats(-100, 100), reverse=st.booleans())
def test_unit_origin_and_direction_of_the_joint_do_not_matter(seed, scale, shift, reverse):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, 4)
    shown = demonstrate(scene, random_moves(rng, scene, 2), Sensing(), rng)
    polarity = Polarity.LARGER_OPEN if reverse else Polarity.LARGER_CLOSED
    other = (-scale if reverse else scale) * shown.joint + shift
    assert read_gripper(shown.stamps, other, FingerJointConfig(polarity=polarity)) == read_gripper(
        shown.stamps, shown.joint
    )


@given(seed=st.integers(0, 2**32), std=st.floats(1e-6, 1.0), n=st.integers(0, 3000))
def test_a_gripper_that_rests_has_no_events_however_noisy(seed, std, n):
    joint = np.random.default_rng(seed).normal(0.2, std, n)
    assert read_gripper(np.arange(n) / 50.0, joint).events == ()


def test_a_half_closing_is_reported_and_no_event():
    t = np.arange(0.0, 10.0, 0.02)
    joint = np.interp(t, [1, 1.5, 3, 3.5, 5, 6, 7], [0, 1, 1, 0, 0, 0.55, 0])
    reading = read_gripper(t, joint)
    assert [e.action for e in reading.events] == [GripperAction.CLOSE, GripperAction.OPEN]
    [(stamp, closure)] = reading.half_closings
    assert stamp == pytest.approx(6.0, abs=0.05) and closure == pytest.approx(0.55, abs=0.02)


@pytest.mark.parametrize(
    "levels", [{}, {"open_level": 0.0, "closed_level": 1.0}, {"open_level": 0.3, "closed_level": 5.0}]
)
def test_a_hand_that_closes_to_a_third_on_something_wide_has_closed(levels):
    """Levels, also wrong ones, only say which way the joint goes."""
    t = np.arange(0.0, 14.0, 0.02)
    joint = np.interp(t, [1, 1.5, 3, 3.5, 6, 6.5, 9, 9.5], [0, 1, 1, 0, 0, 0.33, 0.33, 0])
    reading = read_gripper(t, joint, FingerJointConfig(**levels))
    assert [e.stamp for e in reading.events] == pytest.approx([1.5, 3.0, 6.5, 9.0], abs=0.05)
    assert reading.half_closings == ()


def test_a_glitch_shorter_than_the_debounce_is_no_event():
    t = np.arange(0.0, 10.0, 0.02)
    joint = np.interp(t, [5, 5.5, 8, 8.5], [0, 1, 1, 0])
    joint[100:103] = 1.0
    assert len(read_gripper(t, joint).events) == 2
    assert len(read_gripper(t, joint, FingerJointConfig(debounce=0.0)).events) == 4


@given(gives=st.floats(0.0, 0.12), takes=st.floats(3.0, 6.0), reverse=st.booleans())
def test_a_thing_that_gives_way_for_seconds_is_held_from_when_the_fingers_only_go_on_slowly(gives, takes, reverse):
    """Cloth, foam, a servo that goes on squeezing: as public recordings of SO-101 arms show it."""
    t = np.arange(0.0, 16.0, 1 / 15)
    closed = np.interp(t, [4, 5, 5 + takes, 12, 13], [0.0, 0.9 - gives, 0.9, 0.9, 0.0])
    joint, polarity = (255 - 200 * closed, Polarity.LARGER_OPEN) if reverse else (closed, Polarity.LARGER_CLOSED)
    close, _ = read_gripper(t, joint, FingerJointConfig(polarity=polarity)).events
    slow = 0.05 * 0.9  # of the way, a second
    if gives / takes < 0.5 * slow:
        assert close.stamp == pytest.approx(5.0, abs=0.15)
    assert 4.8 <= close.stamp - close.unsure <= 5.2  # where the tool is looked for


def test_a_short_turn_in_the_midst_of_an_opening_is_no_closing():
    t = np.arange(0.0, 16.0, 0.05)
    joint = np.interp(t, [3, 4, 5, 5.3, 5.4, 6, 9, 10, 12, 13], [0.99, 0.7, 0.7, 0.85, 0.85, 0, 0, 0.6, 0.6, 0])
    reading = read_gripper(t, joint)
    assert [e.action for e in reading.events] == [GripperAction.OPEN, GripperAction.CLOSE, GripperAction.OPEN]
    assert [at for at, _ in reading.half_closings] == pytest.approx([5.35], abs=0.1)


@given(higher=st.floats(0.3, 0.6), before=st.booleans())
def test_a_half_closing_beside_a_shallow_hold_leaves_its_dates_alone(higher, before):
    """The hand holds something wide, and on its way to it or from it its fingers move further than that."""
    t = np.arange(0.0, 24.0, 0.03)
    joint = np.interp(t, [1, 2, 4, 5, 10, 10.5, 14, 14.5], [0, 1, 1, 0, 0, 0.3, 0.3, 0])
    at = 8.0 if before else 17.0
    joint = np.maximum(joint, np.interp(t, [at - 0.5, at, at + 0.5], [0, higher, 0]))
    reading = read_gripper(t, joint)
    assert [e.stamp for e in reading.events] == pytest.approx([2, 4, 10.5, 14], abs=0.1)
    assert [stamp for stamp, _ in reading.half_closings] == pytest.approx([at], abs=0.1)


@given(rate=st.floats(5, 1000), rest=st.floats(0.1, 2.0), stands=st.floats(0.2, 4.0))
def test_a_closing_just_before_the_recording_ends_is_dated_there_at_any_rate(rate, rest, stands):
    """At high rates the level's line once went on through the seconds before the fingers moved."""
    end = 6.0 + stands + rest
    t = np.arange(0.0, end, 1.0 / rate)
    joint = np.interp(t, [1, 2, 4, 5, 5 + stands, 6 + stands], [0, 1, 1, 0.1, 0.1, 0.98])
    *_, close = read_gripper(t, joint).events
    assert close.action is GripperAction.CLOSE
    assert close.stamp == pytest.approx(6.0 + stands, abs=0.15 + 1.5 / rate)


@pytest.mark.parametrize("back", [0.05, 0.15, 0.25, 0.3])
@pytest.mark.parametrize("ends", [False, True])
def test_fingers_that_go_past_where_they_then_stay_have_not_opened(back: float, ends: bool):
    t = np.arange(0.0, 8.0 if ends else 14.0, 0.05)
    joint = np.interp(t, [3, 4, 4.05, 4.2, 9, 10], [0, 1, 1, 1 - back, 1 - back, 0])
    events = read_gripper(t, joint).events
    assert [e.action for e in events] == [GripperAction.CLOSE, GripperAction.OPEN][: 1 if ends else 2]
    assert 4.0 - back - 0.06 <= events[0].stamp <= 4.2  # from when they first were at the level at which they then rest
    assert ends or events[1].stamp == pytest.approx(9.0, abs=0.15)


@pytest.mark.parametrize(
    "wrong",
    [
        {"min_turn": 0.0},
        {"deep": 1.5},
        {"rest": -1.0},
        {"open_level": 0.0},
        {"open_level": 1.0, "closed_level": 1.0},
        {"debounce": -1.0},
        {"min_travel": 0.0},
    ],
)
def test_settings_that_cannot_work_are_refused(wrong):
    with pytest.raises(MbdError):
        FingerJointConfig(**wrong)


def test_stamps_and_positions_of_different_length_are_refused():
    with pytest.raises(MbdError, match="expected"):
        read_gripper([0.0, 1.0], [0.0])
