"""The execution node before an arm that stops, is stopped, or dies: real messages and actions, one process.

What the node sends is taken by an arm of the test, which counts every goal.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from mbd_execution.ros.node import ExecutionNode
from mbd_execution.synthetic import blocks, demonstration
from mbd_model.objects import Role
from mbd_model.ros.conversions import scene_to_msg, stamp_to_msg, task_to_msg
from mbd_model.ros.qos import LATCHED, SENSOR
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import StopCause
from mbd_msgs import msg as m
from mbd_msgs.action import MoveGripper, MoveTool
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.task import Future
from sensor_msgs.msg import JointState

SIZES = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
JOINTS = 0.05  # [s] between two joint states


class StoppableArm:
    """An arm, its driver, and the person at it; ``goals`` are those that came, taken or not."""

    def __init__(self, domain: int, state_dir: Path) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.peer = rclpy.create_node("arm", context=self.context)
        self.executor.add_node(self.peer)
        self.goals: list[str] = []
        self.state_dir = state_dir
        self.person = StopLine(self.peer)
        self.refuses = False
        self.end: Callable[[str], dict[str, Any] | None] = lambda _: None  # fields of a result that fails
        self.hangs = False
        self.under_way: list[Future] = []
        self.out = {
            topic: self.peer.create_publisher(kind, topic, LATCHED)
            for topic, kind in (
                ("interaction/state", m.SessionState),
                ("interaction/assists", m.Assists),
                ("demonstration/task", m.Task),
                ("perception/target_scene", m.Scene),
                ("mapping/estimate", m.MappingEstimate),
            )
        }
        words: dict[str, Any] = {
            "goal_callback": self._consider,
            "cancel_callback": self._cancelled,
        }
        self.servers = [
            ActionServer(self.peer, MoveTool, "cell/move_tool", self._tool, **words),
            ActionServer(self.peer, MoveGripper, "cell/move_gripper", self._gripper, **words),
        ]
        self.joints = self.peer.create_publisher(JointState, "j2n6s300_driver/out/joint_state", SENSOR)
        self.beating = True
        self.peer.create_timer(JOINTS, lambda: self.joints.publish(JointState()) if self.beating else None)
        self.node: ExecutionNode | None = None
        self.progress: list[m.Progress] = []
        self.peer.create_subscription(m.Progress, "interaction/progress", self.progress.append, LATCHED)
        self._publish_inputs()
        self.start()

    def start(self, **parameters: Any) -> None:
        """The execution node is started, or started again."""
        if self.node is not None:
            self.executor.remove_node(self.node)
            self.node.destroy_node()
        overrides = [Parameter("state_dir", value=str(self.state_dir)), Parameter("look_again", value=False)]
        overrides += [Parameter(name, value=value) for name, value in parameters.items()]
        self.node = ExecutionNode(context=self.context, parameter_overrides=overrides)
        self.executor.add_node(self.node)

    def _publish_inputs(self) -> None:
        task = demonstration(blocks(Role.SOURCE, "s", SIZES), [("s1", "s2", (0, 0)), ("s3", "s1", (0, 0))])
        task_msg, scene = task_to_msg(task), scene_to_msg(blocks(Role.TARGET, "t", SIZES))
        task_msg.header.stamp, scene.header.stamp = stamp_to_msg(1), stamp_to_msg(2)
        assists = m.Assists()
        assists.header.stamp = stamp_to_msg(3)
        estimate = m.MappingEstimate(confidence=1.0, strategy="mbd")
        estimate.mapping.pairs = [m.Correspondence(source_id=f"s{k}", target_id=f"t{k}") for k in (1, 2, 3)]
        estimate.task_stamp, estimate.scene_stamp, estimate.assists_stamp = (stamp_to_msg(k) for k in (1, 2, 3))
        self.out["demonstration/task"].publish(task_msg)
        self.out["perception/target_scene"].publish(scene)
        self.out["interaction/assists"].publish(assists)
        self.out["mapping/estimate"].publish(estimate)
        self.say()

    def say(self, *, paused: bool = False, phase: int = m.SessionState.EXECUTE) -> None:
        self.out["interaction/state"].publish(m.SessionState(session="s", phase=phase, paused=paused))

    def _consider(self, goal: Any) -> GoalResponse:
        what = "move" if isinstance(goal, MoveTool.Goal) else "open" if goal.command == goal.OPEN else "close"
        self.goals.append(what)
        return GoalResponse.REJECT if self.refuses else GoalResponse.ACCEPT

    def _cancelled(self, _: object) -> CancelResponse:
        for future in self.under_way:
            future.set_result(None)
        self.under_way.clear()
        return CancelResponse.ACCEPT

    async def _do(self, handle: Any, result: Any, what: str) -> Any:
        if self.hangs:
            self.under_way.append(Future(executor=self.executor))
            await self.under_way[-1]
        fields = self.end(what)
        for name, value in (fields or {"success": True}).items():
            setattr(result, name, value)
        if handle.is_cancel_requested:
            result.success = False
            handle.canceled()
        elif fields is None:
            handle.succeed()
        else:
            handle.abort()
        return result

    async def _tool(self, handle: Any) -> MoveTool.Result:
        return await self._do(handle, MoveTool.Result(reached=handle.request.target.pose), "move")

    async def _gripper(self, handle: Any) -> MoveGripper.Result:
        close = handle.request.command == MoveGripper.Goal.CLOSE
        return await self._do(handle, MoveGripper.Result(holding=close), "close" if close else "open")

    def until(self, done: Callable[[], bool], what: str = "") -> None:
        end = time.monotonic() + 40.0
        while not done():
            assert time.monotonic() < end, f"waited in vain {what}; goals {self.goals[-8:]}, {self.progress[-1:]}"
            self.executor.spin_once(timeout_sec=0.02)

    def carrying(self) -> None:
        """Until the object has been taken and is in the air."""
        self.until(lambda: "close" in self.goals and len(self.goals) - self.goals.index("close") > 2, "to carry")

    def quiet(self, looks: int = 4) -> list[str]:
        """The goals that come while the node looks that often what there is to do."""
        before, looked = len(self.goals), [0]
        timer = self.peer.create_timer(0.25, lambda: looked.__setitem__(0, looked[0] + 1))
        self.until(lambda: looked[0] >= looks)
        self.peer.destroy_timer(timer)
        return self.goals[before:]

    @property
    def held(self) -> bool:
        return self.person.latch.held

    def close(self) -> None:
        self.executor.shutdown()
        if self.node is not None:
            self.node.destroy_node()
        self.peer.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def arm(ros_domain: int, tmp_path: Path) -> Iterator[StoppableArm]:
    made = StoppableArm(ros_domain, tmp_path)
    yield made
    made.close()


@pytest.mark.parametrize("code", [MoveTool.Result.EMERGENCY_STOP, MoveTool.Result.PROTECTIVE_STOP, 0])
def test_an_emergency_stop_while_carrying_is_followed_by_no_goal_until_a_person_lets_go_on(
    arm: StoppableArm, code: int
):
    arm.carrying()
    arm.end = lambda what: (
        {"success": False, "message": "emergency stop", "error_code": code} if what == "move" else None
    )
    arm.until(lambda: arm.held, "for the stop")
    assert "emergency stop" in arm.person.latch.reason
    assert arm.quiet() == []
    arm.until(lambda: arm.progress[-1].status == m.Progress.STOPPED)
    arm.end = lambda _: None
    arm.person.release()
    arm.until(lambda: arm.progress[-1].status == m.Progress.FINISHED, "for the end")
    assert arm.goals.count("open") == 4  # before each grasp and at each place: nothing was taken twice


def test_a_hand_on_the_stop_cuts_the_motion_short_and_a_node_started_again_still_stands(arm: StoppableArm):
    arm.carrying()
    arm.hangs = True
    arm.until(lambda: bool(arm.under_way))
    arm.person.stop(StopCause.PERSON, "a hand on the stop")
    arm.until(lambda: not arm.under_way, "for the cancel")
    arm.hangs = False
    assert arm.quiet() == []
    arm.start()
    arm.say()
    assert arm.quiet() == []
    arm.person.release()
    arm.until(lambda: arm.progress[-1].status == m.Progress.FINISHED, "for the end")


def test_joint_states_that_stop_coming_stop_the_robot(arm: StoppableArm):
    arm.carrying()
    arm.hangs = True
    arm.until(lambda: bool(arm.under_way))
    arm.beating = False
    arm.until(lambda: arm.held, "for the stop")
    assert "no joint states" in arm.person.latch.reason and arm.person.latch.cause is StopCause.DRIVER_LOST
    arm.beating, arm.hangs = True, False
    assert arm.quiet() == []
    arm.person.release()
    arm.until(lambda: arm.progress[-1].status == m.Progress.FINISHED, "for the end")


def test_before_the_first_joint_state_nothing_moves_unless_the_robot_gives_none(ros_domain: int, tmp_path: Path):
    arm = StoppableArm(ros_domain, tmp_path)
    try:
        arm.beating = False
        arm.start(joint_state="j2n6s300_driver/out/other")
        arm.goals.clear()
        assert arm.quiet() == []
        arm.start(joint_state="")
        arm.until(lambda: bool(arm.goals))
    finally:
        arm.close()


def test_an_arm_whose_actions_are_gone_stops_the_robot(arm: StoppableArm):
    arm.carrying()
    arm.hangs = True
    arm.until(lambda: bool(arm.under_way))
    for server in arm.servers:
        server.destroy()
    arm.until(lambda: arm.held, "for the stop")
    assert "any more" in arm.person.latch.reason


def test_random_stops_failures_and_restarts_never_see_a_goal_while_it_stands(arm: StoppableArm):
    rng = np.random.default_rng(7)
    for _ in range(6):
        how, held_up = rng.choice(["hand", "fails", "again"]), int(rng.integers(1, 6))
        count = len(arm.goals)
        arm.until(lambda count=count, held_up=held_up: len(arm.goals) >= count + held_up or done(arm))
        if done(arm):
            break
        if how == "fails":
            arm.end = lambda _: {"success": False, "message": "protective stop"}
        else:
            arm.person.stop(StopCause.PERSON, "a hand on the stop")
        arm.until(lambda: arm.held, "for the stop")
        arm.say(paused=True)  # as the dialogue does
        if how == "again":
            arm.start()
        else:
            arm.until(lambda: arm.progress[-1].status == m.Progress.STOPPED, "for the word of it")
        assert arm.quiet(2) == []
        arm.end = lambda _: None
        arm.say()
        arm.person.release()
    arm.until(lambda: done(arm), "for the end")


def done(arm: StoppableArm) -> bool:
    return bool(arm.progress) and arm.progress[-1].status == m.Progress.FINISHED
