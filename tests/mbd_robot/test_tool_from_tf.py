"""The tool's pose off tf: the robot node against real transforms, sent as robot_state_publisher sends them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import yaml
from cell_and_robot import Playground, playground
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from mbd_model.ros.conversions import stamp_to_msg, time_from_msg
from mbd_model.ros.qos import EVENTS
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.profiles.find import robot_profile
from mbd_robot.ros.interfaces import interface
from mbd_robot.topics import TOOL_POSE
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_robot" / "config"


@pytest.fixture
def by_tf(tmp_path: Path) -> Path:
    content = yaml.safe_load((CONFIG / "ur5e.robot.yaml").read_text())
    content["tool_pose"] |= {"source": "tf", "frame": "tool0"}
    del content["safety"]
    file = tmp_path / "by_tf.yaml"
    file.write_text(yaml.safe_dump(content))
    return file


class Transforms:
    """What robot_state_publisher sends, of one joint state at a time."""

    def __init__(self, there: Playground) -> None:
        self.kind = interface("tf2_msgs", "msg", "TFMessage")
        fixed = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.moving = there.node.create_publisher(self.kind, "/tf", QoSProfile(depth=100))
        self.fixed = there.node.create_publisher(self.kind, "/tf_static", fixed)
        self.joints = there.node.create_publisher(JointState, "joint_states", QoSProfile(depth=10))

    def transform(self, parent: str, child: str, position: object, quaternion: object, stamp: int) -> TransformStamped:
        made = TransformStamped(child_frame_id=child)
        made.header.frame_id, made.header.stamp = parent, stamp_to_msg(stamp)
        t, q = made.transform.translation, made.transform.rotation
        t.x, t.y, t.z = (float(v) for v in np.asarray(position))
        q.x, q.y, q.z, q.w = (float(v) for v in np.asarray(quaternion))
        return made


def test_the_tool_is_where_tf_says_it_is(ros_domain: int, by_tf: Path):
    profile = robot_profile(str(by_tf))
    chain = ArmChain(robot_profile("ur5e"))
    joints = np.array(profile.arm.ready)
    tool = chain.tool_pose(joints)
    flange = dataclasses.replace(
        tool,
        position=tool.position - tool.rotation.apply(profile.tool_pose.offset),
        quaternion=(tool.rotation * Rotation.from_euler("z", -profile.tool_pose.turn)).as_quat(),
    )
    with playground(ros_domain) as there:
        node = there.start_robot(str(by_tf), sim_time=False)
        sent = Transforms(there)
        # The base does not turn with the arm's first link, and the flange hangs at a link of its own.
        turn = Rotation.from_euler("z", 0.5)
        between = turn.inv().apply(flange.position)
        static = [sent.transform("world", "base_link", (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0), 0)]
        sent.fixed.publish(sent.kind(transforms=static))
        said: list[str] = []
        there.node.create_subscription(
            DiagnosticArray, "diagnostics", lambda m: said.append(m.status[0].message), EVENTS
        )
        state = JointState(name=[*profile.arm.joints, *profile.hand.joints], position=[*joints.tolist(), 0.0])
        stamp = node.get_clock().now().nanoseconds

        def joints_only() -> bool:
            sent.joints.publish(state)
            return any("tf knows no way from 'base_link' to 'tool0'" in text for text in said)

        there.until(joints_only)

        def received() -> bool:
            moving = [
                sent.transform("base_link", "shoulder_link", (0.0, 0.0, 0.0), turn.as_quat(), stamp),
                sent.transform("shoulder_link", "tool0", between, (turn.inv() * flange.rotation).as_quat(), stamp),
            ]
            sent.moving.publish(sent.kind(transforms=moving))
            return TOOL_POSE in there.received

        there.until(received)
        msg = there.received[TOOL_POSE]
        p = msg.pose.position
        assert (p.x, p.y, p.z) == pytest.approx(tuple(tool.position), abs=1e-6)
        assert time_from_msg(msg.header.stamp) == pytest.approx(stamp * 1e-9)
        assert msg.header.frame_id == "base_link"
