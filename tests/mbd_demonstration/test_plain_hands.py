"""Hands that say little are understood: those that report only open and closed, slow ones, and those that rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperAction

CLOSED_FROM, CLOSED_TO = (5.0, 13.0), (9.0, 17.0)
ACTS = [GripperAction.CLOSE, GripperAction.OPEN] * 2


@given(rate=st.floats(1, 1000), phase=st.floats(0, 1), unit=st.sampled_from([0.04, 0.085, 1.0, 100.0, 255.0]))
def test_a_hand_that_says_only_open_or_closed_is_read_at_any_rate(rate: float, phase: float, unit: float):
    t = np.arange(phase / rate, 22.0, 1.0 / rate)
    closed = sum(((t > a) & (t < b)).astype(float) for a, b in zip(CLOSED_FROM, CLOSED_TO, strict=True))
    for joint, polarity in ((unit * closed, Polarity.LARGER_CLOSED), (unit - unit * closed, Polarity.LARGER_OPEN)):
        events = read_gripper(t, joint, FingerJointConfig(polarity=polarity)).events
        assert [e.action for e in events] == ACTS
        off = [abs(e.stamp - at) for e, at in zip(events, (5.0, 9.0, 13.0, 17.0), strict=True)]
        assert max(off) <= max(0.1, 1.0 / rate) + 1e-9  # blocks of samples above 100 Hz


@given(
    rate=st.sampled_from([1.0, 2.0, 3.0, 5.0]),
    phase=st.floats(0, 1),
    levels=st.tuples(st.floats(0.25, 1.0), st.floats(0.25, 1.0)),
    takes=st.floats(0.1, 1.0),
    quantum=st.sampled_from([0.0, 0.01]),
)
def test_a_hand_that_is_sampled_slowly_is_read_wherever_its_samples_fall(rate, phase, levels, takes, quantum):
    t = np.arange(phase / rate, 26.0, 1.0 / rate)
    knots = [4 - takes, 4, 8, 8 + takes, 15 - takes, 15, 19, 19 + takes]
    one, other = levels
    joint = np.interp(t, knots, [0, one, one, 0, 0, other, other, 0])
    joint = np.round(joint / quantum) * quantum if quantum else joint
    events = read_gripper(t, joint).events
    assert [e.action for e in events] == ACTS
    off = [abs(e.stamp - at) for e, at in zip(events, (4.0, 8.0, 15.0, 19.0), strict=True)]
    assert max(off) <= max(0.15, 1.5 / rate)


@given(
    seed=st.integers(0, 2**32),
    rate=st.sampled_from([10.0, 30.0, 100.0]),
    std=st.floats(0.2, 3.0),
    level=st.floats(99.0, 101.0),
)
def test_noise_that_is_rounded_to_ticks_is_no_event(seed: int, rate: float, std: float, level: float):
    t = np.arange(0.0, 40.0, 1.0 / rate)
    joint = np.round(np.random.default_rng(seed).normal(level, std, t.size))
    assert read_gripper(t, joint).events == ()


@given(seed=st.integers(0, 2**32), by=st.floats(0.01, 100.0), takes=st.floats(30.0, 600.0))
def test_a_joint_that_drifts_has_not_closed_and_that_is_said(seed: int, by: float, takes: float):
    t = np.arange(0.0, takes, 0.1)
    reading = read_gripper(t, by * t / takes + np.random.default_rng(seed).normal(0.0, 0.002 * by, t.size))
    assert reading.events == () and any("taken as drift" in note for note in reading.notes)


@pytest.mark.parametrize("swapped", [False, True])
def test_levels_that_contradict_the_polarity_are_named_and_make_nothing_worse(swapped: bool):
    t = np.arange(0.0, 20.0, 0.05)
    joint = np.interp(t, [3, 4, 8, 9, 12, 13, 16, 17], [0, 1, 1, 0, 0, 0.5, 0.5, 0])
    # Of a pair that cannot both be right, the one by which the recording begins open.
    levels = {"open_level": 1.0, "closed_level": 0.0} if swapped else {"open_level": 0.0, "closed_level": 1.0}
    polarity = Polarity.LARGER_CLOSED if swapped else Polarity.LARGER_OPEN
    reading = read_gripper(t, joint, FingerJointConfig(polarity=polarity, **levels))
    assert reading.events == read_gripper(t, joint).events
    [note] = reading.notes
    assert "contradict" in note and ("the polarity, is followed" in note) == swapped


def test_a_reading_that_begins_closed_names_the_other_polarity():
    t = np.arange(0.0, 20.0, 0.05)
    joint = np.interp(t, [3, 4, 8, 9], [0, 1, 1, 0])
    assert read_gripper(t, joint).notes == ()
    [note] = read_gripper(t, joint, FingerJointConfig(polarity=Polarity.LARGER_OPEN)).notes
    assert "larger_closed" in note and "--polarity" in note
