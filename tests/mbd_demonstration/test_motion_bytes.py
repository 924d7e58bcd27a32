"""Poses and joint states read from their bytes are what ROS's own reading gives."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.ros.motion_bytes import JointStateReader, pose_from_bytes
from mbd_model.ros.conversions import time_to_msg
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

STAMPS = st.floats(0.0, 2e9)
NUMBERS = st.floats(-1e3, 1e3)
NAMES = st.text(st.characters(codec="utf-8", exclude_characters="\0", exclude_categories=("Cs",)), max_size=12)


@given(stamp=STAMPS, frame=NAMES, numbers=st.lists(NUMBERS, min_size=7, max_size=7))
def test_a_pose(stamp: float, frame: str, numbers: list[float]):
    msg = PoseStamped()
    msg.header.stamp, msg.header.frame_id = time_to_msg(stamp), frame
    p, q = msg.pose.position, msg.pose.orientation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = numbers
    read, name, position, quaternion = pose_from_bytes(bytes(serialize_message(msg)))
    assert read == pytest.approx(stamp, abs=1e-6)
    assert (name, [*position, *quaternion]) == (frame, numbers)


@given(
    frame=NAMES,
    states=st.lists(st.tuples(STAMPS, st.lists(NAMES, max_size=5), st.lists(NUMBERS, max_size=5)), min_size=1),
)
def test_joint_states_whose_names_and_numbers_change(frame: str, states: list[tuple[float, list[str], list[float]]]):
    reader = JointStateReader()
    for stamp, names, positions in [*states, *states]:
        msg = JointState(name=names, position=positions, velocity=[1.0] * len(positions))
        msg.header.stamp, msg.header.frame_id = time_to_msg(stamp), frame
        read, found, numbers = reader.read(bytes(serialize_message(msg)))
        assert read == pytest.approx(stamp, abs=1e-6)
        assert (list(found), list(numbers)) == (names, positions)
