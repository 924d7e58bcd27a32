"""The robot node: one arm and hand, whatever their drivers speak, as the suite's topics and actions."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import clock_seconds, header, time_from_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.polling.subscriptions import subscribe_polled
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_model.ros.run_node import run_node
from mbd_model.ros.stop_line import StopLine
from mbd_model.ros.word_check import WordCheck
from mbd_model.session import Phase
from mbd_model.stop import StopLatch
from mbd_msgs.msg import SessionState, WizardGripper
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool

from mbd_robot.geometry import RobotToolPose, hand_zone_box
from mbd_robot.joints import JointMerge
from mbd_robot.motion.standstill import Stated
from mbd_robot.parameters import ROBOT
from mbd_robot.profiles.find import robot_profile
from mbd_robot.profiles.robot import Reliability
from mbd_robot.ros.guided_arm import GuidedArm
from mbd_robot.ros.moving.arm_motion import arm_motion
from mbd_robot.ros.moving.hand_motion import HandMotion
from mbd_robot.ros.perceived_boxes import PerceivedBoxes
from mbd_robot.ros.robot_actions import RobotActions
from mbd_robot.ros.safety.safety_watch import SafetyWatch
from mbd_robot.ros.safety.stop_services import StopServices
from mbd_robot.ros.tool_frames import pose_to_msg
from mbd_robot.ros.tool_source import ToolSource
from mbd_robot.topics import HAND_GUIDING, JOINT_STATE, TOOL_POSE

if TYPE_CHECKING:
    from mbd_robot.kinematics.chain import ArmChain

KEPT = 1000  # joint states while this node is held up, of arm and hand together: a second of the fastest driver
LOOK = 0.02  # [s, wall clock] between two looks at the joint states: each costs as much as ten of them
PERIOD = 0.5  # [s] between two looks at the driver, and at a guided arm


class RobotNode(TableNode):
    """Publishes robot/out/{tool_pose,joint_state}; serves robot/{move_tool,move_gripper,hand_guiding}."""

    def __init__(self, **options: Any) -> None:
        super().__init__(ROBOT, **options)
        values = self.values
        self.profile = robot_profile(values["robot"])
        self._merge = JointMerge(self.profile.arm.joints, self.profile.hand.joints)
        self._tool: RobotToolPose | None = None
        self._poses = 0  # of the tool, stated so far
        self._passed = {TOOL_POSE: -math.inf, JOINT_STATE: -math.inf}
        self._received_at, self._complained = -math.inf, ""
        self._phase: Phase | None = None
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._tool_out = self.create_publisher(PoseStamped, TOOL_POSE, SENSOR)
        self._joints_out = self.create_publisher(JointState, JOINT_STATE, SENSOR)
        self._diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        self._stop = StopLine(self, self._on_stop)
        self._driver_stop = StopServices(self, self.profile.arm)
        self._safety = SafetyWatch(self, self.profile.title, self.profile.safety, self._stop)
        self._guiding = GuidedArm(self, self.profile, self._steady)
        self._actions = RobotActions(
            self,
            self.profile.base_frame,
            values["speed"],
            tool=lambda: self._tool,
            tool_stated=self._tool_stated,
            refusal=self._why_nothing_moves,
        )
        self._source = ToolSource(self, self.profile, None, self._on_tool)
        self._actions.hand = HandMotion(self, self.profile.hand, self._merge.hand_stated)
        zone = hand_zone_box(values["hand_zone"], values["table_height"])
        self._boxes = PerceivedBoxes(self, () if zone is None else (zone,), heed=values["keep_clear"])
        topic = self.profile.arm.description_topic
        if topic and self.profile.needs_model:
            self.create_subscription(String, topic, lambda msg: self._use_model(msg.data), LATCHED)
        else:
            self._use_model("")
        reliable = self.profile.joint_states.reliability is Reliability.RELIABLE
        # A hole in what is passed on is a hole in a demonstration.
        quality = QoSProfile(
            depth=KEPT, reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        )
        for name in self.profile.joint_states.topics:
            subscribe_polled(self, JointState, name, self._on_joints, qos=quality, period=LOOK)
        self._words = WordCheck(self, "wizard/gripper")
        self.create_subscription(WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        self.create_service(SetBool, HAND_GUIDING, self._on_guiding)
        self.create_timer(PERIOD, self._look, clock=self._steady)
        self.get_logger().info(f"{self.profile.title}; {self.profile.tested}")

    def _use_model(self, description: str) -> None:
        """The arm's model is known now."""
        try:
            if self.profile.needs_model:
                self._source.chain = self._loaded(description)
            planned = self._loaded(description) if self.profile.needs_model else None
            self._actions.arm = arm_motion(
                self,
                self.profile,
                planned,
                joints=self._merge.arm_positions,
                tool=lambda: self._tool,
                around=self._boxes.now,
                table_height=self.values["table_height"],
            )
        except MbdError as error:
            if not description:
                raise
            self.get_logger().error(f"{self.profile.arm.description_topic}: {error}")

    def _loaded(self, description: str) -> ArmChain:
        try:
            from mbd_robot.kinematics.chain import ArmChain
        except ImportError as error:
            raise MbdError(
                f"{self.profile.title} needs kinematics of ours, and {error.name} is not installed: "
                "pip install -r requirements/sim.txt -r requirements/robot.txt"
            ) from error
        return ArmChain(self.profile, description, self.values["table_height"])

    def _on_joints(self, msg: JointState) -> None:
        stamp = time_from_msg(msg.header.stamp)
        if not self._merge.take(stamp, msg.name, msg.position, msg.velocity):
            self._pass_on_joints(stamp)
            return
        self._received_at = time.monotonic()
        arm = self._merge.arm_positions()
        if arm is not None and self._source.by_joints and self._due(TOOL_POSE, stamp):
            self._source.on_joints(stamp, arm)
        self._pass_on_joints(stamp)

    def _due(self, name: str, stamp: float) -> bool:
        """Whether one may be passed on again; a little early counts."""
        if 0.0 <= stamp - self._passed[name] < 0.9 / self.values["rate"]:
            return False
        self._passed[name] = stamp
        return True

    def _pass_on_joints(self, stamp: float) -> None:
        names = (*self._merge.arm, *self._merge.hand)
        readings = self._merge.readings(names)
        if readings is None or not self._due(JOINT_STATE, stamp):
            return
        newest = max(r.stamp for r in readings)
        msg = JointState(header=header(newest, self.profile.base_frame), name=list(names))
        msg.position = [r.position for r in readings]
        msg.velocity = [r.velocity for r in readings]
        self._joints_out.publish(msg)
        hand = self._merge.hand_position()
        if hand is not None:
            self._guiding.hand_at(hand)

    def _tool_stated(self) -> Stated | None:
        return None if self._tool is None else Stated(self._poses, tuple(float(v) for v in self._tool.position))

    def _on_tool(self, stamp: float, pose: RobotToolPose) -> None:
        self._tool, self._poses = pose, self._poses + 1
        self._guiding.tool_at(pose)
        # Of joints it was asked before the pose was computed.
        if not self._source.by_joints and not self._due(TOOL_POSE, stamp):
            return
        self._tool_out.publish(PoseStamped(header=header(stamp, self.profile.base_frame), pose=pose_to_msg(pose)))

    def _on_gripper(self, msg: WizardGripper) -> None:
        """The operator's word to the hand, in a demonstration: in execution the execution node closes it."""
        self._guiding.gripper_event()
        self._words.count()
        if self._phase is Phase.EXECUTE:
            return
        # A hand closes also on an arm that is guided.
        why = "a motion is under way" if self._actions.busy else self._stop.why or self._safety.why or self._lost()
        hand = self._actions.hand
        if hand is None or why or (why := hand.ready()):
            self.get_logger().error(f"wizard/gripper: the hand stays as it is: {why}")
            return
        self._actions.busy = True
        close = msg.command == WizardGripper.CLOSE

        async def move() -> None:
            try:
                end = await hand.move(close)
                if not end.success:
                    self.get_logger().error(f"wizard/gripper: {end.message}")
            finally:
                self._actions.busy = False

        if self.executor is not None:
            self.executor.create_task(move)

    def _on_state(self, msg: SessionState) -> None:
        phase = Phase(msg.phase)
        if phase is self._phase:
            return
        before, self._phase = self._phase, phase
        if phase is Phase.DEMONSTRATE:
            self._guiding.switch(True)
        elif before is Phase.DEMONSTRATE:
            self._guiding.switch(False)
        elif phase is Phase.ABORTED:
            self._actions.stop()

    def _on_stop(self, latch: StopLatch) -> None:
        """Somebody stopped the robot: what is under way at the drivers ends, and no hand opens."""
        if latch.held:
            self._actions.stop()
        self._driver_stop.call(latch.held)

    def _on_guiding(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._guiding.switch(bool(request.data))
        response.success = True
        response.message = self.profile.guiding.instruction or "asked for; see the diagnostics"
        return response

    def _why_nothing_moves(self) -> str:
        """Why the robot may not move now; "" when it may."""
        if self._stop.why or self._safety.why:
            return self._stop.why or self._safety.why
        if self._guiding.guided:
            return "hand guiding is on: switch it off first (robot/hand_guiding)"
        return self._lost()

    def _lost(self) -> str:
        missing = self._merge.missing(self.profile.arm.joints)
        topics = ", ".join(self.profile.joint_states.topics)
        if missing:
            return f"no joint state of {', '.join(missing)} on {topics} yet: is the driver running, the profile right?"
        return self._source.missing()

    def _look(self) -> None:
        """Say how the driver is, and whether a guided arm moves."""
        self._safety.look()
        silent = time.monotonic() - self._received_at
        lost = self._lost()
        if not lost and silent > self.values["lost_after"] and not self._clock_stands():
            lost = f"no joint states for {silent:.1f} s: the driver is lost"
        complaint = lost or self._guiding.complaint()
        if complaint and complaint != self._complained:
            self.get_logger().warning(complaint)
        self._complained = complaint
        level = DiagnosticStatus.ERROR if lost else DiagnosticStatus.WARN if complaint else DiagnosticStatus.OK
        status = DiagnosticStatus(
            level=level, name="robot", message=complaint or "ok", hardware_id=self.profile.title
        )  # fmt: skip
        self._diagnostics.publish(DiagnosticArray(header=header(clock_seconds(self.get_clock())), status=[status]))

    def _clock_stands(self) -> bool:
        """While a simulated clock stands (a teacher waits for the operator) the arm has nothing to publish."""
        newest = self._merge.newest()
        # One that is behind the joints was set back, and stands no more than one that goes on.
        return bool(np.isfinite(newest)) and abs(clock_seconds(self.get_clock()) - newest) < self.values["lost_after"]


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("robot", RobotNode)


if __name__ == "__main__":
    main()
