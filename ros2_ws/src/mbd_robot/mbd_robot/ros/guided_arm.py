"""The arm made soft while a demonstration is recorded, and watched: does it give way at all?"""

from __future__ import annotations

from mbd_model.ros.conversions import clock_seconds
from rclpy.clock import Clock
from rclpy.node import Node

from mbd_robot.geometry import RobotToolPose
from mbd_robot.guiding import StiffArmWatch
from mbd_robot.hand import closing
from mbd_robot.profiles.robot import GripperEvents, RobotProfile
from mbd_robot.ros.guiding_switch import GuidingControl


class GuidedArm:
    """Switches hand guiding, and follows what the tool and the hand do meanwhile.

    Args:
        node: the client's.
        profile: of the robot.
        clock: that never stands still.
    """

    def __init__(self, node: Node, profile: RobotProfile, clock: Clock) -> None:
        self._node, self._profile, self._clock = node, profile, clock
        self._switch = GuidingControl(node, profile.guiding)
        self._watch = StiffArmWatch()
        self._closed: bool | None = None

    @property
    def guided(self) -> bool:
        """The driver has said that the arm is soft, or a person was asked to make it so."""
        return self._switch.guided

    def switch(self, on: bool) -> None:
        """Ask the driver; what it answers is logged."""

        def answered(success: bool, message: str) -> None:
            if success:
                self._node.get_logger().info(f"hand guiding: {message}")
            else:
                self._node.get_logger().error(f"hand guiding: {message}")
            if success and on:
                self._watch.begin(clock_seconds(self._clock))

        self._watch.end()
        self._switch.set(on, answered)

    def tool_at(self, pose: RobotToolPose) -> None:
        """Where the tool is."""
        x, y, z = (float(v) for v in pose.position)
        self._watch.tool_at((x, y, z))

    def gripper_event(self) -> None:
        """The operator told the hand to close or to open."""
        self._watch.gripper_event()

    def hand_at(self, position: float) -> None:
        """Where the hand's joints are [rad or m]: of a hand that nobody commands, its turns are the events."""
        if self._profile.hand.events is not GripperEvents.JOINT:
            return
        share = closing(position, self._profile.hand)
        closed = self._closed
        if share > 0.6:
            closed = True
        elif share < 0.3:
            closed = False
        if closed is not self._closed and self._closed is not None:
            self._watch.gripper_event()
        self._closed = closed

    def complaint(self) -> str:
        """What is wrong with the guiding, for people; "" for nothing."""
        return self._watch.complaint(clock_seconds(self._clock))
