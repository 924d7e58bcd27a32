"""An answer of the arm that is lost on its way does not end the work; an arm that is lost stops it."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from mbd_execution.goals import Ended, Grip, ToolGoal
from mbd_execution.ros.arm_client import PATIENCE, ArmClient
from mbd_model.stop import MotionError
from mbd_msgs.action import MoveGripper
from rclpy.task import Future


class AnsweringArm:
    """An arm whose answers are given by the test; ``ends``: how it reported its motions; ``served``: it is running."""

    def __init__(self, arm: ArmClient, ends: list[Ended | None]) -> None:
        self.arm, self.ends = arm, ends
        self.goals: list[Future] = []
        self.cancelled = 0
        self.results: list[Future] = []
        self.served = True
        arm._gripper.send_goal_async = lambda goal: self._asked(self.goals)
        arm._gripper.server_is_ready = lambda: self.served

    def _asked(self, futures: list[Future]) -> Future:
        futures.append(Future())
        return futures[-1]

    def accept(self, future: Future) -> None:
        handle = SimpleNamespace(
            accepted=True, get_result_async=lambda: self._asked(self.results), cancel_goal_async=self._cancel
        )
        future.set_result(handle)

    def _cancel(self) -> None:
        self.cancelled += 1


@pytest.fixture
def answering(ros_domain: int) -> Iterator[AnsweringArm]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("arm_user", context=context)
    ends: list[Ended | None] = []

    def ended(how: Ended | None, _reached: ToolGoal | None) -> None:
        ends.append(how)

    yield AnsweringArm(ArmClient(node, "move_tool", "move_gripper", "base", ended), ends)
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def test_a_goal_of_which_nothing_is_received_counts_as_not_taken_and_its_late_answer_as_none(
    answering: AnsweringArm,
):
    answering.arm.start(Grip(close=True), 0.0)
    answering.arm.look_after(0.9 * PATIENCE)
    assert answering.arm.moving and answering.ends == []
    answering.arm.look_after(1.1 * PATIENCE)
    assert not answering.arm.moving and answering.ends == [None]
    answering.accept(answering.goals[0])
    assert answering.results == [] and answering.cancelled == 1


def test_an_arm_that_answers_no_goal_twice_stops_the_work(answering: AnsweringArm):
    for number in (1, 2):
        answering.arm.start(Grip(close=True), 0.0)
        answering.arm.look_after(1.1 * PATIENCE)
        assert len(answering.ends) == number
    last = answering.ends[-1]
    assert last is not None and last.stops and last.error is MotionError.DRIVER_LOST


def test_an_arm_that_goes_on_refusing_goals_stops_the_work_so_that_none_is_taken_when_it_is_ready_again(
    answering: AnsweringArm,
):
    for at in (0.0, 0.5 * PATIENCE, 1.1 * PATIENCE):
        answering.arm.start(Grip(close=False), at)
        answering.goals[-1].set_result(SimpleNamespace(accepted=False))
    assert answering.ends[:2] == [None, None]
    last = answering.ends[2]
    assert last is not None and last.stops and last.error is MotionError.PROTECTIVE_STOP


@pytest.mark.parametrize(
    ("status", "success", "code", "error"),
    [
        (GoalStatus.STATUS_ABORTED, False, MotionError.NOT_REACHED, MotionError.NOT_REACHED),
        (GoalStatus.STATUS_SUCCEEDED, False, MotionError.NOT_REACHED, MotionError.NOT_REACHED),
        (GoalStatus.STATUS_ABORTED, False, MotionError.EMERGENCY_STOP, MotionError.EMERGENCY_STOP),
        (GoalStatus.STATUS_ABORTED, False, 0, MotionError.NONE),
        (GoalStatus.STATUS_ABORTED, True, MotionError.NOT_REACHED, MotionError.NONE),
        (GoalStatus.STATUS_ABORTED, False, 200, MotionError.NONE),
        (GoalStatus.STATUS_CANCELED, False, MotionError.NOT_REACHED, MotionError.CANCELED),
        (GoalStatus.STATUS_UNKNOWN, False, 0, MotionError.DRIVER_LOST),
    ],
)
def test_the_actions_status_counts_and_only_a_stated_not_reached_is_tried_again(
    answering: AnsweringArm, status: int, success: bool, code: int, error: MotionError
):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    result = MoveGripper.Result(success=success, holding=True, error_code=int(code))
    answering.results[0].set_result(SimpleNamespace(result=result, status=status))
    [end] = answering.ends
    assert end is not None and not end.success and end.error is error
    assert end.stops == (error is not MotionError.NOT_REACHED)


def test_a_protective_stop_amid_a_pause_is_no_pause(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.arm.stop()
    result = MoveGripper.Result(message="protective stop", error_code=MoveGripper.Result.PROTECTIVE_STOP)
    answering.results[0].set_result(SimpleNamespace(result=result, status=GoalStatus.STATUS_ABORTED))
    assert [end is not None and end.stops for end in answering.ends] == [True]


def test_a_motion_that_was_stopped_on_request_is_no_failure(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.arm.stop()
    answering.results[0].set_result(SimpleNamespace(result=MoveGripper.Result(), status=GoalStatus.STATUS_CANCELED))
    assert answering.ends == [None] and answering.cancelled == 1


def test_a_result_that_does_not_come_is_asked_for_again_and_taken_once(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.arm.look_after(1.1 * PATIENCE)
    assert len(answering.results) == 2
    for future in reversed(answering.results):
        future.set_result(
            SimpleNamespace(result=MoveGripper.Result(success=True, holding=True), status=GoalStatus.STATUS_SUCCEEDED)
        )
    assert answering.ends == [Ended(True, holding=True)]


def test_a_motion_whose_arm_is_gone_stops_the_work_and_its_late_result_counts_as_none(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.served = False
    answering.arm.look_after(0.9 * PATIENCE)
    assert answering.arm.moving and answering.ends == []
    answering.arm.look_after(1.1 * PATIENCE)
    [end] = answering.ends
    assert not answering.arm.moving and end is not None and end.stops and end.error is MotionError.DRIVER_LOST
    answering.results[0].set_result(
        SimpleNamespace(result=MoveGripper.Result(success=True), status=GoalStatus.STATUS_SUCCEEDED)
    )
    assert answering.ends == [end]
