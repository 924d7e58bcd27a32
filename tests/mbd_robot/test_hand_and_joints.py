from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.ros.stand_in.camera import compressed_depth, in_encoding, jpeg
from mbd_robot.geometry import RobotToolPose
from mbd_robot.guiding import EVENTS, UNUSED, StiffArmWatch
from mbd_robot.hand import arrived_open, closing, is_holding
from mbd_robot.images import ImageError, decode_color, decode_depth
from mbd_robot.joints import SET_BACK, JointMerge
from mbd_robot.profiles.find import robot_names, robot_profile
from mbd_robot.ros.tool_frames import driver_pose, suite_pose
from scipy.spatial.transform import Rotation
from std_msgs.msg import Header

ARM, HAND = ("a1", "a2", "a3"), ("f1",)
NAMES = (*ARM, *HAND, "wheel")


@given(st.permutations(NAMES), st.integers(1, 5), st.randoms())
def test_how_joints_are_ordered_and_split_over_messages_changes_nothing(names, parts, random):
    positions = dict(zip(NAMES, (0.1, 0.2, 0.3, 0.4, 9.0), strict=True))
    merge = JointMerge(ARM, HAND)
    for part in range(parts):
        chosen = names[part::parts]
        merge.take(1.0, chosen, [positions[n] for n in chosen], [0.0] * random.randint(0, len(chosen)))
    assert merge.missing() == ()
    assert merge.arm_positions() == (0.1, 0.2, 0.3)
    assert merge.hand_position() == 0.4


def test_a_joint_that_was_never_stated_is_named_and_nothing_is_made_up():
    merge = JointMerge(ARM, HAND)
    assert merge.take(1.0, ("a1", "a3"), (0.0, 1.0))
    assert merge.missing() == ("a2", "f1")
    assert merge.arm_positions() is None
    assert merge.newest() == -math.inf


@given(at=st.floats(0.0, 1e6), back=st.floats(0.0, 1e6))
def test_of_a_clock_that_was_set_back_far_the_newest_message_counts_and_of_one_that_was_overtaken_the_other(at, back):
    merge = JointMerge(ARM, HAND)
    merge.take(at + back, ARM, (0.0, 0.0, 0.0))
    merge.take(at, ARM, (1.0, 1.0, 1.0))
    overtaken = 0.0 < (at + back) - at < SET_BACK
    assert merge.arm_positions() == ((0.0, 0.0, 0.0) if overtaken else (1.0, 1.0, 1.0))


def test_what_is_older_or_no_number_or_lacks_a_position_is_passed_over():
    merge = JointMerge(ARM, HAND)
    merge.take(2.0, ARM, (1.0, 2.0, 3.0))
    merge.take(1.5, ARM, (9.0, 9.0, 9.0))
    merge.take(3.0, ("a1", "a2"), (math.nan,))
    assert merge.arm_positions() == (1.0, 2.0, 3.0)
    assert not merge.take(3.0, ("f1", "wheel"), (0.5, 1.0))


@pytest.mark.parametrize("name", robot_names())
@given(share=st.floats(0.0, 1.0))
def test_a_hand_holds_exactly_when_it_stops_short_of_closed(name: str, share: float):
    """Whichever way its positions run: a 2F-85's grow as it closes, Franka's shrink."""
    hand = robot_profile(name).hand
    position = hand.open + share * (hand.closed - hand.open)
    assert closing(position, hand) == pytest.approx(share, abs=1e-9)
    if abs(share - (1 - hand.holding_margin)) > 1e-6:
        assert is_holding(position, hand) == (share < 1 - hand.holding_margin)
    if abs(share - 0.1) > 1e-6:
        assert arrived_open(position, hand) == (share < 0.1)


def test_an_arm_that_says_on_and_stays_stiff_is_noticed():
    watch = StiffArmWatch()
    watch.begin(0.0)
    watch.tool_at((0.4, 0.0, 0.3))
    for _ in range(EVENTS):
        assert watch.complaint(1.0) == ""
        watch.gripper_event()
    watch.tool_at((0.4, 0.001, 0.3))
    assert "stiff" in watch.complaint(2.0)
    watch.tool_at((0.4, 0.1, 0.3))
    assert watch.complaint(3.0) == ""


def test_an_arm_that_is_guided_or_not_said_to_be_soft_is_not_complained_about():
    watch = StiffArmWatch()
    watch.gripper_event()
    watch.gripper_event()
    assert watch.complaint(100.0) == ""
    watch.begin(100.0)
    assert watch.complaint(100.0 + UNUSED - 1) == ""
    assert "is the arm stiff?" in watch.complaint(100.0 + UNUSED + 1)
    watch.end()
    assert watch.complaint(1000.0) == ""


vectors = st.tuples(*[st.floats(-1, 1)] * 3)


@pytest.mark.parametrize("name", robot_names())
@given(vectors, vectors)
def test_the_driver_s_tool_of_the_suite_s_tool_is_the_driver_s_tool(name, position, turn):
    profile = robot_profile(name).tool_pose
    driver = RobotToolPose(np.array(position), Rotation.from_rotvec(turn).as_quat())
    again = driver_pose(suite_pose(driver, profile), profile)
    assert again.position == pytest.approx(driver.position, abs=1e-9)
    assert abs(again.quaternion @ driver.quaternion) == pytest.approx(1.0)


def test_compressed_depth_keeps_millimetres_and_metres_within_its_steps():
    depth = np.tile(np.linspace(0.4, 2.0, 64), (8, 1))
    depth[0] = 0.0
    mm = np.round(depth * 1000).astype(np.uint16)
    sent = compressed_depth(mm, "16UC1", Header())
    assert (decode_depth(bytes(sent.data), "16UC1") == mm).all()
    metres = np.where(depth > 0, depth, np.nan).astype(np.float32)
    sent = compressed_depth(metres, "32FC1", Header())
    got = decode_depth(bytes(sent.data), "32FC1")
    assert np.isnan(got[0]).all()
    # A step of its inverse depth: depth squared over A = 100 * 101.
    assert got[1:] == pytest.approx(metres[1:], abs=2.0**2 / 10100 * 1.5)


def test_compressed_colour_keeps_its_channels_in_order():
    rgb = np.zeros((16, 16, 3), np.uint8)
    rgb[..., 0], rgb[..., 2] = 200, 40
    got = decode_color(bytes(jpeg(rgb, Header()).data))
    assert got.mean((0, 1)) == pytest.approx((200, 0, 40), abs=4)
    assert (in_encoding(rgb, "bgra8")[0, 0] == (40, 0, 200, 255)).all()


@pytest.mark.parametrize("data", [b"", b"x" * 5, b"x" * 40])
def test_what_is_no_image_is_refused(data: bytes):
    with pytest.raises(ImageError):
        decode_depth(data, "16UC1")
    with pytest.raises(ImageError):
        decode_color(data or b"y")
