"""The execution node: does the rest of the task on the target objects, by the arm's actions, in EXECUTE."""

from __future__ import annotations

from typing import Any

from mbd_model.execution_progress import Failure, Status, Verdict
from mbd_model.ros.conversions import (
    assists_from_msg,
    clock_seconds,
    estimate_from_msg,
    inputs_from_msg,
    progress_from_msg,
    progress_to_msg,
    scene_from_msg,
    stamp_from_msg,
    stamp_to_msg,
    state_from_msg,
    task_from_msg,
)
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import LATCHED
from mbd_model.ros.run_node import run_node
from mbd_model.ros.stop_line import StopLine
from mbd_model.session import Phase
from mbd_model.stop import MotionError, StopCause, StopLatch
from mbd_msgs.msg import Assists, MappingEstimate, Scene, SessionState, Task
from mbd_msgs.msg import Progress as ProgressMsg
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Header

from mbd_execution.choosing import may_be_stopped, next_motion
from mbd_execution.execution import Work, assisted_again, begin, halted, interrupted, motion_ended, progress, released
from mbd_execution.goals import Ended, Look, ToolGoal
from mbd_execution.parameters import EXECUTION, hand_config
from mbd_execution.plan import Plan, plan
from mbd_execution.resume import resumed
from mbd_execution.ros.arm_client import ArmClient
from mbd_execution.ros.heartbeat import Heartbeat
from mbd_execution.ros.scene_publisher import ScenePublisher
from mbd_execution.ros.table_view import TableView

PERIOD = 0.2  # [s] until an arm that was busy, or not there, is asked again
CAUSES = {MotionError.EMERGENCY_STOP: StopCause.EMERGENCY_STOP, MotionError.DRIVER_LOST: StopCause.DRIVER_LOST}


class ExecutionNode(TableNode):
    """Publishes interaction/progress and execution/scene; moves the cell's arm, or a real one of the same actions."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(EXECUTION, **kwargs)
        values = self.values
        self._arm = ArmClient(self, values["move_tool"], values["move_gripper"], values["base_frame"], self._on_ended)
        self._view = TableView(self, values["observe"], self._on_looked)
        self._looks = bool(values["look_again"])
        self._hand = hand_config(values)
        self._heartbeat = Heartbeat(self, values["joint_state"], values["heartbeat"])
        self._published = LatchedPublisher(self, ProgressMsg, "interaction/progress", values["state_dir"])
        self._scene = ScenePublisher(self, values["base_frame"])
        self._state: SessionState | None = None
        self._assists: Assists | None = None
        self._task: Task | None = None
        self._target: Scene | None = None
        self._estimate: MappingEstimate | None = None
        self._work: Work | None = None
        self._table: tuple[int, int] = (0, 0)
        self._planned_from = 0
        self._warned = ""
        self._forget_unreadable()
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        self.create_subscription(Assists, "interaction/assists", self._on_assists, LATCHED)
        self.create_subscription(Task, "demonstration/task", self._on_task, LATCHED)
        self.create_subscription(Scene, "perception/target_scene", self._on_target, LATCHED)
        self.create_subscription(MappingEstimate, "mapping/estimate", self._on_estimate, LATCHED)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(PERIOD, self._on_timer, clock=self._steady)
        self._stop = StopLine(self, self._on_stop, values["state_dir"])
        self.create_timer(self._heartbeat.period, self._on_heartbeat, clock=self._steady)
        if not self._heartbeat.topic:
            self.get_logger().warning("joint_state is empty: nothing watches whether the arm's driver is alive")

    @property
    def _phase(self) -> Phase | None:
        return Phase(self._state.phase) if self._state else None

    def _forget_unreadable(self) -> None:
        """Begin without the kept progress where it holds what cannot be."""
        try:
            if self._published.last is not None:
                progress_from_msg(self._published.last)
        except ValueError as error:
            self.get_logger().error(f"the kept progress is unusable and forgotten: {error}")
            self._published.forget()

    def _on_state(self, msg: SessionState) -> None:
        state_from_msg(msg)  # one that cannot be is refused here, and the one before stays
        entered = self._state is None or self._state.phase != msg.phase
        self._state = msg
        if entered and self._phase in (Phase.OBSERVE_TARGET, Phase.ABORTED):
            self._work = None  # the objects are laid out again, or nothing is done any more
        if entered and self._phase is Phase.EXECUTE:
            self._publish_progress(again=True)
        self._advance()

    def _on_assists(self, msg: Assists) -> None:
        assists_from_msg(msg)
        self._assists = msg
        self._advance()

    def _on_task(self, msg: Task) -> None:
        task_from_msg(msg)
        self._task = msg
        self._advance()

    def _on_target(self, msg: Scene) -> None:
        scene_from_msg(msg)
        self._target = msg
        self._advance()

    def _on_estimate(self, msg: MappingEstimate) -> None:
        estimate_from_msg(msg)
        self._estimate = msg
        self._advance()

    def _on_ended(self, ended: Ended | None, reached: ToolGoal | None) -> None:
        if self._work is not None:
            self._work = interrupted(self._work, reached) if ended is None else motion_ended(self._work, ended)
            if ended is not None and not ended.success:
                self.get_logger().warning(ended.message)
        if ended is not None and ended.stops:
            self._stop.stop(CAUSES.get(ended.error, StopCause.PROTECTIVE_STOP), f"the arm: {ended.message}")
        if ended is not None or reached is not None:  # a refused goal is tried again by the timer
            self._advance()

    def _on_looked(self, ended: Ended) -> None:
        if self._work is not None:
            self._work = motion_ended(self._work, ended)
        if not ended.success:
            self.get_logger().warning(f"could not look at the table: {ended.message}")
        self._advance()

    @property
    def _busy(self) -> bool:
        return self._arm.moving or self._view.looking

    def _now(self) -> float:
        return clock_seconds(self._steady)

    def _on_timer(self) -> None:
        self._arm.look_after(self._now())
        self._view.look_after(self._now())
        missing = self._arm.lost(self._now())
        if missing and self._in_charge:
            if self._arm.moving:
                self._arm.forget()
            self._stop.stop(StopCause.DRIVER_LOST, f"nobody serves '{missing}' any more: the arm's driver is lost")
        self._advance()

    @property
    def _in_charge(self) -> bool:
        """A motion of this node is under way, or comes next."""
        return self._arm.moving or (self._work is not None and self._phase is Phase.EXECUTE)

    def _on_heartbeat(self) -> None:
        wrong = self._heartbeat.look()
        if wrong and self._in_charge:
            self._stop.stop(StopCause.DRIVER_LOST, wrong)

    def _on_stop(self, latch: StopLatch) -> None:
        """Everything stands, however far the motion under way is; or a person lets it go on."""
        if latch.held:
            self._arm.stop()
            self._view.forget()
            if self._work is not None:
                self._work = halted(self._work, latch.reason)
                self._publish_progress()
            return
        self._heartbeat.begin()
        if self._work is not None:
            self._work = released(self._work)
        self._advance()

    def _advance(self) -> None:
        """Do what there is to do now."""
        if self._state is None or self._phase is None:
            return
        if self._stop.latch.held:
            self._arm.stop()  # a goal that was sent just before may have been taken since
            return
        allowed = self._phase is Phase.EXECUTE and not self._state.paused
        if self._view.looking and not allowed:
            self._view.forget()
            self._work = None if self._work is None else interrupted(self._work, None)
        if self._busy:
            if not allowed and (self._work is None or may_be_stopped(self._work)):
                self._arm.stop()
            return
        allowed = allowed and self._planned()
        at_work = not self._state.paused and self._phase in (Phase.ASSIST, Phase.EXECUTE)
        if not at_work or self._work is None or not self._arm_is_there():
            return
        self._work, motion = next_motion(self._work, allowed)
        self._scene.publish(self._work)
        self._publish_progress()
        if isinstance(motion, Look):
            self._view.start(self._now())
        elif motion is not None:
            self._arm.start(motion, self._now())

    def _planned(self) -> bool:
        """Whether the work's plan comes of what is known now; plans again when it does not and can."""
        if self._assists is None or self._task is None or self._target is None or self._estimate is None:
            return False
        stamp = stamp_from_msg(self._assists.header.stamp)
        try:
            task, target = task_from_msg(self._task), scene_from_msg(self._target)
            estimate = estimate_from_msg(self._estimate)
        except ValueError as error:  # MbdError is one
            self._warn(f"cannot plan: {error}")
            return False
        inputs = inputs_from_msg(self._estimate)
        table = (inputs.task_stamp, inputs.scene_stamp)
        there = (stamp_from_msg(self._task.header.stamp), stamp_from_msg(self._target.header.stamp))
        if (*table, inputs.assists_stamp) != (*there, stamp):
            return False
        if self._work is not None and table == self._table and stamp == self._planned_from:
            return True
        new = plan(task, target, estimate.executed.as_dict)
        if self._work is None or table != self._table:
            self._work = self._begun(new, stamp)
        else:
            self._work = self._answered(self._work, new, frozenset(a.source_id for a in self._assists.assists))
        self._table, self._planned_from = table, stamp
        return True

    def _answered(self, work: Work, new: Plan, assisted: frozenset[str]) -> Work:
        """The work after new assists, and what was answered to its question if that was asked."""
        state = None if self._state is None else state_from_msg(self._state)
        if work.failure is None or state is None or work.failure.failure in (Failure.NONE, Failure.NO_COUNTERPART):
            return assisted_again(work, new, assisted)
        # No assist was withdrawn for the question: only its own answer counts.
        verdict = Verdict.NONE if work.failure.step in state.skipped else state.verdict
        return assisted_again(work, new, frozenset(), verdict)

    def _begun(self, new: Plan, stamp: int) -> Work:
        """New work, or the work this node was at when it was killed."""
        last = self._published.last
        if (
            last is not None
            and self._state is not None
            and last.session == self._state.session
            and stamp_from_msg(last.assists_stamp) == stamp
        ):
            return resumed(new, self._hand, [Status(s) for s in last.step_statuses], looks=self._looks)
        return begin(new, self._hand, looks=self._looks)

    def _arm_is_there(self) -> bool:
        missing = self._arm.ready()
        if missing:
            self._warn(f"nobody serves the action '{missing}': start the arm, or set its name by parameter")
        elif self._heartbeat.waiting:
            self._warn(
                f"no joint states on '{self._heartbeat.topic}' yet: start the arm's driver, set joint_state to its "
                "topic, or to '' where the robot gives none"
            )
            return False
        return not missing

    def _warn(self, text: str) -> None:
        if text != self._warned:
            self._warned = text
            self.get_logger().warning(text)

    def _publish_progress(self, again: bool = False) -> None:
        """Publish the progress when it has changed, or ``again``."""
        if self._work is None or self._state is None:
            return
        now = progress(self._work)
        msg = progress_to_msg(now, self._state.session, stamp_to_msg(self._planned_from))
        last = self._published.last
        if last is not None:
            msg.header = Header(stamp=last.header.stamp)
            if msg == last and not again:
                return
        msg.header.stamp = self.get_clock().now().to_msg()
        if last is None or progress_from_msg(last).doing != now.doing:
            self.get_logger().info(now.text)
        self._published.publish(msg)


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("execution", ExecutionNode)


if __name__ == "__main__":
    main()
