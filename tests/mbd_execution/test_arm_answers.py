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


class Telling:
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
def telling(ros_domain: int) -> Iterator[Telling]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("arm_user", context=context)
    ends: list[Ended | None] = []

    def ended(how: Ended | None, _reached: ToolGoal | None) -> None:
        ends.append(how)

    yield Telling(ArmClient(node, "move_tool", "move_gripper", "base", ended), ends)
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def test_a_goal_of_which_nothing_is_received_counts_as_not_taken_and_its_late_answer_as_none(telling: Telling):
    telling.arm.start(Grip(close=True), 0.0)
    telling.arm.look_after(0.9 * PATIENCE)
    assert telling.arm.moving and telling.ends == []
    telling.arm.look_after(1.1 * PATIENCE)
    assert not telling.arm.moving and telling.ends == [None]
    telling.accept(telling.goals[0])
    assert telling.results == []


def test_a_result_that_does_not_come_is_asked_for_again_and_taken_once(telling: Telling):
    telling.arm.start(Grip(close=True), 0.0)
    telling.accept(telling.goals[0])
    telling.arm.look_after(1.1 * PATIENCE)
    assert len(telling.results) == 2
    for future in reversed(telling.results):
        future.set_result(SimpleNamespace(result=MoveGripper.Result(success=True, holding=True)))
    assert telling.ends == [Ended(True, holding=True)]


def test_a_motion_whose_arm_is_gone_counts_as_stopped_and_its_late_result_as_none(telling: Telling):
    telling.arm.start(Grip(close=True), 0.0)
    telling.accept(telling.goals[0])
    telling.served = False
    telling.arm.look_after(0.9 * PATIENCE)
    assert telling.arm.moving and telling.ends == []
    telling.arm.look_after(1.1 * PATIENCE)
    assert not telling.arm.moving and telling.ends == [None]
    telling.results[0].set_result(SimpleNamespace(result=MoveGripper.Result(success=True)))
    assert telling.ends == [None]
