"""The execution node: does the rest of the task on the target objects, by the arm's actions, in EXECUTE."""

from __future__ import annotations

from typing import Any

from mbd_interaction.ros.conversions import estimate_received, nanoseconds, target_received, task_received, time_of
from mbd_model.execution_progress import Progress, Status
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.qos import LATCHED
from mbd_model.ros.run_node import run_node
from mbd_model.session import Phase
from mbd_msgs.msg import Assists, MappingEstimate, Scene, SessionState, Task
from mbd_msgs.msg import Progress as ProgressMsg
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from mbd_execution.choosing import may_be_stopped, next_motion
from mbd_execution.execution import Work, assisted_again, begin, interrupted, motion_ended, progress
from mbd_execution.goals import Ended, ToolGoal
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_execution.resume import resumed
from mbd_execution.ros.arm_client import ArmClient

PERIOD = 0.2  # [s] until an arm that was busy, or not there, is asked again


class ExecutionNode(Node):
    """Publishes interaction/progress; drives cell/move_tool and cell/move_gripper (or what a real arm calls them)."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("execution", **kwargs)
        state_dir = self._declare("state_dir", "", "folder that keeps the progress over a restart; empty: not kept")
        self._arm = ArmClient(
            self,
            self._declare("move_tool", "cell/move_tool", "action that moves the tool to a pose"),
            self._declare("move_gripper", "cell/move_gripper", "action that opens or closes the hand"),
            self._declare("base_frame", "j2n6s300_link_base", "frame of the scenes and of the goals"),
            self._on_ended,
        )
        self._hand = HandConfig(
            widest=self._declare("widest_grasp", 0.095, "[m] a wider object is taken by its rim"),
            highest=self._declare("highest_tool", 0.40, "[m] the tool goes at most this high"),
        )
        self._published = LatchedPublisher(self, ProgressMsg, "interaction/progress", state_dir)
        self._state: SessionState | None = None
        self._facts: dict[str, Any] = {}
        self._work: Work | None = None
        self._table: tuple[int, int] = (0, 0)
        self._planned_from = 0
        self._warned = ""
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        for kind, topic in (
            (Assists, "interaction/assists"),
            (Task, "demonstration/task"),
            (Scene, "perception/target_scene"),
            (MappingEstimate, "mapping/estimate"),
        ):
            self.create_subscription(kind, topic, lambda msg, topic=topic: self._on_fact(topic, msg), LATCHED)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(PERIOD, self._on_timer, clock=self._steady)

    def _declare(self, name: str, default: Any, description: str) -> Any:
        return self.declare_parameter(name, default, ParameterDescriptor(description=description, read_only=True)).value

    @property
    def _phase(self) -> Phase | None:
        return Phase(self._state.phase) if self._state else None

    def _on_state(self, msg: SessionState) -> None:
        entered = self._state is None or self._state.phase != msg.phase
        self._state = msg
        if entered and self._phase in (Phase.OBSERVE_TARGET, Phase.ABORTED):
            self._work = None  # the objects are laid out anew, or nothing is done any more
        if entered and self._phase is Phase.EXECUTE:
            self._say(again=True)
        self._advance()

    def _on_fact(self, topic: str, msg: Any) -> None:
        self._facts[topic] = msg
        self._advance()

    def _on_ended(self, ended: Ended | None, reached: ToolGoal | None) -> None:
        if self._work is not None:
            self._work = interrupted(self._work, reached) if ended is None else motion_ended(self._work, ended)
            if ended is not None and not ended.success:
                self.get_logger().warning(ended.message)
        if ended is not None or reached is not None:  # a refused goal is tried again by the timer
            self._advance()

    def _now(self) -> float:
        return self._steady.now().nanoseconds / 1e9

    def _on_timer(self) -> None:
        self._arm.look_after(self._now())
        self._advance()

    def _advance(self) -> None:
        """Do what there is to do now."""
        if self._state is None or self._phase is None:
            return
        allowed = self._phase is Phase.EXECUTE and not self._state.paused
        if self._arm.moving:
            if not allowed and (self._work is None or may_be_stopped(self._work)):
                self._arm.stop()
            return
        if self._state.paused or self._phase not in (Phase.ASSIST, Phase.EXECUTE):
            return
        allowed = allowed and self._planned()
        if self._work is None or not self._arm_is_there():
            return
        self._work, motion = next_motion(self._work, allowed)
        self._say()
        if motion is not None:
            self._arm.start(motion, self._now())

    def _planned(self) -> bool:
        """Whether the work's plan comes of what is known now; plans anew when it does not and can."""
        if len(self._facts) < 4:
            return False
        assists = self._facts["interaction/assists"]
        stamp = nanoseconds(assists.header.stamp)
        try:
            task = task_received(self._facts["demonstration/task"], 0)
            target = target_received(self._facts["perception/target_scene"], 0)
            heard = estimate_received(self._facts["mapping/estimate"], 0)
        except ValueError as error:  # MbdError is one
            self._warn(f"cannot plan: {error}")
            return False
        table = (task.stamp, target.stamp)
        if (heard.task_stamp, heard.scene_stamp, heard.assists_stamp) != (*table, stamp):
            return False
        if self._work is not None and table == self._table and stamp == self._planned_from:
            return True
        new = plan(task.task, target.scene, heard.estimate.mapping.as_dict)
        if self._work is None or table != self._table:
            self._work = self._begun(new, stamp)
        else:
            self._work = assisted_again(self._work, new, frozenset(a.source_id for a in assists.assists))
        self._table, self._planned_from = table, stamp
        return True

    def _begun(self, new: Any, stamp: int) -> Work:
        """New work, or the work this node was at when it was killed."""
        last = self._published.last
        if last is not None and last.session == self._state.session and nanoseconds(last.assists_stamp) == stamp:
            return resumed(new, self._hand, [Status(s) for s in last.step_statuses])
        return begin(new, self._hand)

    def _arm_is_there(self) -> bool:
        missing = self._arm.ready()
        if missing:
            self._warn(f"nobody serves the action '{missing}': start the arm, or set its name by parameter")
        return not missing

    def _warn(self, text: str) -> None:
        if text != self._warned:
            self._warned = text
            self.get_logger().warning(text)

    def _say(self, again: bool = False) -> None:
        """Publish the progress when it has changed, or ``again``."""
        if self._work is None or self._state is None:
            return
        now = progress(self._work)
        msg = progress_to_msg(now, self._state.session, self._planned_from)
        last = self._published.last
        if last is not None:
            msg.header = Header(stamp=last.header.stamp)
            if msg == last and not again:
                return
        msg.header.stamp = self.get_clock().now().to_msg()
        if last is None or last.text != msg.text:
            self.get_logger().info(now.text)
        self._published.publish(msg)


def progress_to_msg(value: Progress, session: str, assists_stamp: int) -> ProgressMsg:
    """The progress of a plan that comes of the assists of that stamp [ns]."""
    return ProgressMsg(
        session=session,
        step_index=value.step_index,
        status=int(value.status),
        text=value.text,
        step_statuses=[int(s) for s in value.step_statuses],
        assists_stamp=time_of(assists_stamp),
    )


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("execution", ExecutionNode)


if __name__ == "__main__":
    main()
