"""An arm that says it can be guided and stays stiff is noticed, whoever closes the hand."""

from __future__ import annotations

import dataclasses

import pytest
from cell_and_robot import played, playground
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mbd_cell.arm.grasp_planning import grasp_pose
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.session import Phase
from mbd_msgs.action import MoveGripper
from mbd_msgs.msg import SessionState, WizardGripper
from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.find import robot_profile
from mbd_robot.profiles.robot import GripperEvents
from mbd_robot.ros.guided_arm import GuidedArm
from rclpy.clock import Clock, ClockType

NOWHERE = RobotToolPose((0.4, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0))  # type: ignore[arg-type]


def test_a_stiff_arm_is_reported_after_the_operator_has_closed_and_opened_the_hand(ros_domain: int):
    with played(ros_domain, "jaco2") as there:
        said: list[str] = []
        state = there.node.create_publisher(SessionState, "interaction/state", LATCHED)
        words = there.node.create_publisher(WizardGripper, "wizard/gripper", EVENTS)

        def on_status(msg: DiagnosticArray) -> None:
            said.extend(s.message for s in msg.status if s.level == DiagnosticStatus.WARN)
            for command in (WizardGripper.CLOSE, WizardGripper.OPEN):
                words.publish(WizardGripper(command=command))

        there.node.create_subscription(DiagnosticArray, "diagnostics", on_status, EVENTS)
        there.until(lambda: words.get_subscription_count() > 0)
        assert not said
        state.publish(SessionState(phase=Phase.DEMONSTRATE.value))
        there.until(lambda: any("it is stiff, or its driver's tool pose stands still" in text for text in said))


@pytest.mark.parametrize("events", [GripperEvents.JOINT, GripperEvents.SPOKEN])
def test_where_nobody_says_a_word_the_turns_of_the_hand_count(ros_domain: int, events: GripperEvents):
    profile = robot_profile("gen3")
    profile = dataclasses.replace(profile, hand=dataclasses.replace(profile.hand, events=events))
    with playground(ros_domain) as there:
        arm = GuidedArm(there.node, profile, Clock(clock_type=ClockType.STEADY_TIME))
        arm.switch(True)
        arm.tool_at(NOWHERE)
        for position in (0.0, 0.3, 0.7, 0.7, 0.4, 0.1):
            assert arm.complaint() == ""
            arm.hand_at(position)
        assert ("stiff" in arm.complaint()) == (events is GripperEvents.JOINT)


def test_kinova_s_fingers_report_a_stall_a_second_late_and_their_abort_is_taken_for_holding(ros_domain: int):
    with played(ros_domain, "jaco2") as there:
        assert there.cell is not None
        cell = there.cell.cell
        thing = cell.simulation.objects["small_red"]
        grasp = grasp_pose(thing, cell.simulation.object_pose("small_red"), near_yaw=0.0)
        x, y, z = grasp.position
        for height in (z + 0.12, z):
            assert there.move(x, y, height, grasp.yaw).success
        settled: list[int] = []

        def closed() -> bool:
            if cell.holding is not None and cell.hand_settled and not settled:
                settled.append(cell.time_ns)
            return ended.done()

        handle = there.sent(there.hand, MoveGripper.Goal(command=MoveGripper.Goal.CLOSE))
        ended = handle.get_result_async()
        there.until(closed)
        result = ended.result().result
        assert (result.success, result.holding) == (True, True), result.message
        assert cell.time_ns - settled[0] > 0.9e9
