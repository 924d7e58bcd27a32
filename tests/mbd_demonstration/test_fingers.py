"""Several fingers make one gripper, whichever of them is stuck, lost or mirrored."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.finger_joint import FingerJointConfig, read_gripper
from mbd_demonstration.hand.fingers import combined, hands, named_fingers, resampled
from mbd_model.errors import MbdError

T = np.arange(0.0, 14.0, 0.02)
MOTION = np.interp(T, [1, 1.5, 3, 3.5, 6, 6.5, 9, 9.5], [0, 1, 1, 0, 0, 0.33, 0.33, 0])


def finger(rng: np.random.Generator, scale: float = 1.0) -> np.ndarray:
    return scale * (MOTION + rng.normal(0.0, 0.002, T.size))


def closings(values: np.ndarray) -> list[float]:
    return [e.stamp for e in read_gripper(T, values, FingerJointConfig()).events]


EVENTS = pytest.approx([1.5, 3.0, 6.5, 9.0], abs=0.08)


@given(
    seed=st.integers(0, 2**32),
    stuck=st.integers(0, 2),
    at=st.floats(-2.0, 2.0),
    scale=st.sampled_from([0.01, 1.0, 6800.0]),
)
def test_one_stuck_finger_of_three_is_left_out_and_named(seed, stuck, at, scale):
    rng = np.random.default_rng(seed)
    fingers = {f"f{k}": finger(rng, scale) for k in range(3)}
    fingers[f"f{stuck}"] = np.full(T.size, at * scale)
    found = combined(fingers)
    assert closings(found.values) == EVENTS
    assert [f"'f{stuck}' is left out" in note for note in found.notes] == [True]


@given(seed=st.integers(0, 2**32), lost=st.integers(0, 2), share=st.floats(0.0, 1.0))
def test_a_finger_that_is_lost_at_any_time_for_any_time_makes_no_event(seed, lost, share):
    rng = np.random.default_rng(seed)
    fingers = {f"f{k}": finger(rng) + 0.3 * k for k in range(3)}
    begin = int(rng.integers(0, T.size))
    fingers[f"f{lost}"][begin : begin + int(share * T.size)] = np.nan
    assert closings(combined(fingers).values) == EVENTS


def test_a_mirrored_joint_is_turned_round_not_averaged_away():
    rng = np.random.default_rng(0)
    found = combined({"knuckle": finger(rng), "mimic": -finger(rng)})
    assert closings(found.values) == EVENTS
    assert "moves against 'knuckle'" in found.notes[0]


@given(seed=st.integers(0, 2**32), rate=st.floats(10, 49))
def test_fingers_of_two_publishers_are_one_hand(seed, rate):
    rng = np.random.default_rng(seed)
    other = np.arange(0.003, 14.0, 1.0 / rate)
    stamps, fingers = resampled(
        {"a": (T, finger(rng)), "b": (other, np.interp(other, T, finger(rng)))}, longest_gap=0.5
    )
    assert stamps.size == T.size
    assert closings(combined(fingers).values) == EVENTS


@pytest.mark.parametrize(
    ("names", "wanted", "found"),
    [
        (["joint_1", "joint_finger_1"], ["j2n6s300_joint_finger_1"], ("joint_finger_1",)),
        (["j2n6s300_joint_finger_1", "j2n6s300_joint_finger_tip_1"], ["joint_finger_1"], ("j2n6s300_joint_finger_1",)),
        (
            ["shoulder", "robotiq_85_left_knuckle_joint"],
            ["j2n6s300_joint_finger_1"],
            ("robotiq_85_left_knuckle_joint",),
        ),
        (
            ["panda_joint7", "panda_finger_joint1", "panda_finger_joint2"],
            [],
            ("panda_finger_joint1", "panda_finger_joint2"),
        ),
        (["shoulder_pan", "gripper"], ["joint_finger_1"], ("gripper",)),
        (["joint_1", "joint_7"], ["joint_finger_1"], ()),
    ],
)
def test_finger_joints_are_found_by_name(names, wanted, found):
    assert named_fingers(names, wanted) == found


def test_the_fingers_of_two_arms_are_two_hands_and_those_of_one_are_one():
    assert hands(["a_finger_joint1", "a_finger_joint2", "b_finger_joint1"]) == {
        "a_": ("a_finger_joint1", "a_finger_joint2"),
        "b_": ("b_finger_joint1",),
    }
    assert list(hands(["robotiq_left_knuckle", "robotiq_right_knuckle", "robotiq_left_inner_finger"])) == ["robotiq_"]


def test_fingers_of_different_length_are_refused():
    with pytest.raises(MbdError, match="the same n"):
        combined({"a": [0.0], "b": [0.0, 1.0]})


def test_fingers_that_do_not_move_together_are_told_and_those_that_do_are_not():
    t = np.arange(0.0, 20.0, 0.05)
    grasp, other = np.interp(t, [4, 5, 9, 10], [0, 1, 1, 0]), np.interp(t, [12, 13, 17, 18], [0, 1, 1, 0])
    notes = combined({"thumb": grasp, "index": 0.8 * grasp, "ring": other}).notes
    assert [note for note in notes if "do not move together" in note] == [
        note for note in notes if "'ring' and 'thumb'" in note
    ]
    assert any("'ring' and 'thumb'" in note for note in notes)
    assert combined({"thumb": grasp, "mimic": -grasp}).notes == ("finger 'mimic' moves against 'thumb': turned round",)
