"""A robot's drivers in the cell: joint states as they are split and named, tool pose, actions, hand guiding."""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped
from mbd_model.ros.conversions import stamp_to_msg
from mbd_robot.profiles.robot import RobotProfile, ToolPoseSource
from mbd_robot.ros.tool_frames import driver_pose, pose_to_msg
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from mbd_cell.ros.stand_in.arm import arm_action, tool_of
from mbd_cell.ros.stand_in.guiding import StandInGuiding
from mbd_cell.ros.stand_in.hand import StandInHand
from mbd_cell.ros.stand_in.safety import StandInSafety
from mbd_cell.stage import Stage


class StandInRobot:
    """What ``OwnRobot`` is, in a driver's words.

    Args:
        node: the server's.
        stage: with the cell.
        profile: what the driver speaks.
    """

    def __init__(self, node: Node, stage: Stage, profile: RobotProfile) -> None:
        self._profile, self._cell = profile, stage.cell
        self._guiding = StandInGuiding(node, profile.guiding)
        self._safety = StandInSafety(node, profile)
        self._hand = StandInHand(node, profile, stage)
        self._arm = arm_action(node, profile, stage.cell, self._refuse)
        player = profile.stand_in
        self._hand_topic = player.hand_topic if player else ""
        # ros2_control's joint_state_broadcaster and Kinova's port are reliable, with short queues.
        self._joints = node.create_publisher(JointState, profile.joint_states.topics[0], QoSProfile(depth=10))
        self._hand_joints: Publisher[JointState] | None = None
        if self._hand_topic:
            self._hand_joints = node.create_publisher(JointState, self._hand_topic, QoSProfile(depth=10))
        self._tool: Publisher[PoseStamped] | None = None
        if profile.tool_pose.source is ToolPoseSource.TOPIC:
            self._tool = node.create_publisher(PoseStamped, profile.tool_pose.topic, QoSProfile(depth=1))
        hand_rate = player.hand_rate if player else profile.joint_states.rate
        self._periods = {"arm": 1e9 / profile.joint_states.rate, "hand": 1e9 / hand_rate}
        self._due = {"arm": 0.0, "hand": 0.0}

    @property
    def soft(self) -> bool:
        """Whether a hand can guide the arm."""
        return self._guiding.soft

    def publish(self) -> None:
        """State where the robot is now, at the driver's rate or each slice of time where that is slower."""
        self._safety.publish(self._cell.time_ns)
        if self._is_due("arm"):
            self._publish_arm()
        if self._hand_joints is not None and self._is_due("hand"):
            self._hand_joints.publish(self._joint_state(self._hand.positions(), velocities=False))

    def update(self) -> bool:
        """See to the goals under way; whether one has ended."""
        stands = self._safety.stands
        ended = [a.update(abort=stands) for a in (self._arm, *self._hand.actions)]
        return any(ended)

    def _refuse(self) -> str:
        if self._safety.refuses:
            return "the robot is stopped"
        if self._guiding.refuses:
            return "hand guiding is on, the trajectory controller is not active"
        return "the arm is moving" if self._cell.busy else ""

    def _is_due(self, what: str) -> bool:
        if self._cell.time_ns < self._due[what]:
            return False
        self._due[what] = self._cell.time_ns + self._periods[what] - 1e6
        return True

    def _publish_arm(self) -> None:
        physics = self._cell.simulation
        joints = dict(zip(self._profile.arm.joints, (float(v) for v in physics.arm_joints), strict=True))
        if self._hand_joints is None:
            joints |= self._hand.positions()
        # joint_state_broadcaster keeps no order of the arm.
        self._joints.publish(self._joint_state(dict(sorted(joints.items(), reverse=True)), velocities=True))
        if self._tool is not None:
            pose = pose_to_msg(driver_pose(tool_of(self._cell), self._profile.tool_pose))
            header = Header(stamp=stamp_to_msg(self._cell.time_ns), frame_id=self._profile.base_frame)
            self._tool.publish(PoseStamped(header=header, pose=pose))

    def _joint_state(self, joints: dict[str, float], *, velocities: bool) -> JointState:
        msg = JointState(header=Header(stamp=stamp_to_msg(self._cell.time_ns)))
        msg.name, msg.position = list(joints), list(joints.values())
        if velocities:
            msg.velocity = [0.0] * len(joints)
        return msg
