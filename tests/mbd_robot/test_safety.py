"""The driver's word of its robot's safety stops the suite, and holds as long as the driver says it."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from cell_and_robot import Playground, played, playground
from mbd_cell.ros.stand_in.safety import BUTTON
from mbd_model.errors import MbdError
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import StopCause
from mbd_msgs.action import MoveGripper, MoveTool
from mbd_robot.profiles.find import robot_names, robot_profile
from mbd_robot.profiles.safety import SafetyCause, SafetyStop, SafetyTopic
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.safety.safety_watch import SafetyWatch
from mbd_robot.topics import TOOL_POSE
from rclpy.action import ActionClient
from std_srvs.srv import SetBool

HERE = (0.4, -0.1, 0.3)


def press(there: Playground, pressed: bool) -> None:
    assert there.call(SetBool, BUTTON, SetBool.Request(data=pressed)).success


@pytest.mark.parametrize("name", robot_names())
def test_every_state_that_a_profile_names_is_one_of_its_message(name: str):
    for topic in robot_profile(name).safety:
        kind = interface(*topic.type.split("/"))
        assert topic.field in kind.get_fields_and_field_types()
        constants = {getattr(kind, n) for n in dir(type(kind)) if n.isupper() and n[0] != "_"} or {0, 1}
        assert {topic.well, *(stop.value for stop in topic.stops)} <= constants
        assert topic.stop_at(topic.well) is None


@pytest.mark.parametrize(
    ("robot", "cause", "word"),
    [
        ("ur5e", StopCause.PROTECTIVE_STOP, "unlock the stop"),
        ("fr3", StopCause.PROTECTIVE_STOP, "not ready"),
        ("gen3", StopCause.PROTECTIVE_STOP, "fault_controller/reset_fault"),
    ],
)
def test_a_robot_that_stands_stops_everything_until_it_may_move_and_a_person_resumes(
    ros_domain: int, robot: str, cause: StopCause, word: str
):
    with played(ros_domain, robot) as there:
        line = StopLine(there.node)
        assert there.move(*HERE).success
        handle = there.sent(there.tool, there.goal(0.45, 0.2, 0.3))
        assert handle.accepted
        press(there, True)
        there.until(lambda: line.latch.held)
        assert (line.latch.cause, word in line.latch.reason) == (cause, True), line.latch.reason
        ended = handle.get_result_async()
        there.until(ended.done)
        assert not ended.result().result.success
        assert ended.result().result.error_code != MoveTool.Result.NOT_REACHED
        assert there.move(*HERE) is None
        assert there.grip(MoveGripper.Goal.OPEN) is None
        first = line.latch.stopped
        line.release()
        there.until(lambda: line.latch.held and line.latch.stopped > first)
        press(there, False)
        line.release()
        there.until(lambda: (done := there.move(*HERE)) is not None and done.success)
        assert not line.latch.held


def test_kinova_s_own_stop_is_called_with_the_suite_s_and_its_start_when_a_person_resumes(ros_domain: int):
    with played(ros_domain, "jaco2") as there:
        assert there.move(*HERE).success
        line = StopLine(there.node)
        line.stop(StopCause.PERSON, "somebody pressed stop")
        there.until(lambda: there.move(*HERE) is None)
        pose = interface("kinova_msgs", "action", "ArmPose")
        driver = ActionClient(there.node, pose, "j2n6s300_driver/tool_pose")
        here = pose.Goal(pose=there.received[TOOL_POSE])
        # The driver itself gives every goal up until it is started again.
        there.until(lambda: not carried_out(there, driver, here))
        line.release()
        there.until(lambda: (done := there.move(0.4, 0.0, 0.3)) is not None and done.success)


def carried_out(there: Playground, driver: ActionClient[Any, Any, Any], goal: Any) -> bool:
    """Whether the driver itself carries a goal out."""
    handle = there.sent(driver, goal)
    if not handle.accepted:
        return False
    ended = handle.get_result_async()
    there.until(ended.done)
    return bool(ended.result().status == GoalStatus.STATUS_SUCCEEDED)


def test_a_message_without_the_field_is_refused_with_those_it_has(ros_domain: int):
    stop = SafetyStop(3, SafetyCause.PROTECTIVE_STOP, "protective stop")
    topic = SafetyTopic("safety", "ur_dashboard_msgs/msg/SafetyMode", "state", 1, (stop,))
    with playground(ros_domain) as there, pytest.raises(MbdError, match="no field 'state'; it has mode"):
        SafetyWatch(there.node, "UR5e", (topic,), StopLine(there.node))
    with pytest.raises(MbdError, match="well is 3, which is one of stops"):
        SafetyTopic("safety", "ur_dashboard_msgs/msg/SafetyMode", "mode", 3, (stop,))
    with pytest.raises(MbdError, match="expected package/msg/Name"):
        SafetyTopic("safety", "SafetyMode", "mode", 1, (stop,))
