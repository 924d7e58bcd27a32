"""An answer of the arm that is lost on its way does not end the work."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest
import rclpy
from mbd_execution.goals import Ended, Grip, ToolGoal
from mbd_execution.ros.arm_client import PATIENCE, ArmClient
from mbd_msgs.action import MoveGripper
from rclpy.task import Future


class AnsweringArm:
    """An arm whose answers are given by the test; ``ends``: how it reported its motions; ``served``: it is running."""

    def __init__(self, arm: ArmClient, ends: list[Ended | None]) -> None:
        self.arm, self.ends = arm, ends
        self.goals: list[Future] = []
        self.results: list[Future] = []
        self.served = True
        arm._gripper.send_goal_async = lambda goal: self._asked(self.goals)
        arm._gripper.server_is_ready = lambda: self.served

    def _asked(self, futures: list[Future]) -> Future:
        futures.append(Future())
        return futures[-1]

    def accept(self, future: Future) -> None:
        handle = SimpleNamespace(accepted=True, get_result_async=lambda: self._asked(self.results))
        future.set_result(handle)


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
    assert answering.results == []


def test_a_result_that_does_not_come_is_asked_for_again_and_taken_once(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.arm.look_after(1.1 * PATIENCE)
    assert len(answering.results) == 2
    for future in reversed(answering.results):
        future.set_result(SimpleNamespace(result=MoveGripper.Result(success=True, holding=True)))
    assert answering.ends == [Ended(True, holding=True)]


def test_a_motion_whose_arm_is_gone_counts_as_stopped_and_its_late_result_as_none(answering: AnsweringArm):
    answering.arm.start(Grip(close=True), 0.0)
    answering.accept(answering.goals[0])
    answering.served = False
    answering.arm.look_after(0.9 * PATIENCE)
    assert answering.arm.moving and answering.ends == []
    answering.arm.look_after(1.1 * PATIENCE)
    assert not answering.arm.moving and answering.ends == [None]
    answering.results[0].set_result(SimpleNamespace(result=MoveGripper.Result(success=True)))
    assert answering.ends == [None]
