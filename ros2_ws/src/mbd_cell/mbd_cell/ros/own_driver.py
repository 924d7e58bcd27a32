"""The cell's robot as the suite's own topics and actions: what a session without a robot's profile reads."""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped
from mbd_model.ros.qos import EVENTS, IMAGES, SENSOR
from mbd_model.ros.stop_line import StopLine
from mbd_model.ros.word_check import WordCheck
from mbd_msgs.msg import WizardGripper
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2

from mbd_cell.arm.hand import GripperCommand
from mbd_cell.physics.camera import Frame
from mbd_cell.ros import conversions as convert
from mbd_cell.ros.motion_actions import MotionActions
from mbd_cell.stage import Stage


class OwnRobot:
    """Publishes tool pose and joints, serves cell/move_tool and cell/move_gripper, listens to wizard/gripper.

    Attributes:
        soft: the arm can be guided by hand; this one always can.
    """

    soft = True

    def __init__(self, node: Node, stage: Stage, driver: str) -> None:
        self._node, self._stage, self._cell = node, stage, stage.cell
        self._stop = StopLine(node)
        self._words = WordCheck(node, "wizard/gripper")
        self._actions = MotionActions(node, stage.cell, self._stop)
        self._tool = node.create_publisher(PoseStamped, f"{driver}/out/tool_pose", SENSOR)
        self._joints = node.create_publisher(JointState, f"{driver}/out/joint_state", SENSOR)
        node.create_subscription(WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)

    def publish(self) -> None:
        """State where the robot is now."""
        self._tool.publish(convert.tool_pose_to_msg(self._cell))
        self._joints.publish(convert.joint_state_to_msg(self._cell))

    def update(self) -> bool:
        """Report how far motions are; whether one has ended."""
        self._actions.update()
        return self._actions.take_ended()

    def _on_gripper(self, msg: WizardGripper) -> None:
        self._words.count()
        log = self._node.get_logger()
        try:
            command = GripperCommand(msg.command)
        except ValueError:
            log.error(f"wizard/gripper: command {msg.command} is neither OPEN (1) nor CLOSE (2)")
            return
        if self._stop.latch.held:
            log.warning(f"wizard/gripper {command.name} ignored: {self._stop.why}")
        elif not self._stage.gripper(command):
            log.warning(f"wizard/gripper {command.name} ignored: the teacher waits for {self._cell.waiting_for!r}")


class OwnCamera:
    """Publishes colour, depth, camera_info, and a cloud on demand."""

    def __init__(self, node: Node) -> None:
        self._color = node.create_publisher(Image, "camera/color/image_raw", IMAGES)
        self._depth = node.create_publisher(Image, "camera/depth/image_raw", IMAGES)
        self._info = node.create_publisher(CameraInfo, "camera/color/camera_info", IMAGES)
        self._points = node.create_publisher(PointCloud2, "camera/points", IMAGES)

    def watched(self) -> bool:
        """Whether anybody listens."""
        return any(p.get_subscription_count() for p in (self._color, self._depth, self._info, self._points))

    def publish(self, frame: Frame, stamp: int) -> None:
        """One image of that time [ns]."""
        self._info.publish(convert.camera_info_to_msg(stamp))
        self._color.publish(convert.color_to_msg(frame, stamp))
        self._depth.publish(convert.depth_to_msg(frame, stamp))
        if self._points.get_subscription_count():
            self._points.publish(convert.cloud_to_msg(frame, stamp))
