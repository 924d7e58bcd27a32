"""The demonstration node: records the tool and the gripper, publishes the task they show."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.ros.conversions import clock_seconds, scene_from_msg, task_from_msg, task_to_msg, time_from_msg
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED, MOTION
from mbd_model.ros.run_node import run_node
from mbd_model.task import Task, TaskStep
from mbd_model.times import to_seconds
from mbd_msgs.msg import Scene as SceneMsg
from mbd_msgs.msg import Task as TaskMsg
from mbd_msgs.msg import WizardGripper
from mbd_msgs.srv import ReviseTask
from rclpy.clock import Clock, ClockType
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.journal import Journal
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording import GripperSource, Recording
from mbd_demonstration.revision import redo_from, shown_again_from, without_last_step
from mbd_demonstration.ros.corrections import answered, corrected
from mbd_demonstration.ros.cut_off import cut_off
from mbd_demonstration.trajectory import ToolTrajectory

JOINT_PERIOD = 1.0  # [s] between two looks at what the finger joint shows so far
LOOK_SHARE = 0.08  # of a core that looks may take
JOURNAL_PERIOD = 0.5  # [s] between two writes of what is recorded
POSE_LATEST = 2.0  # [s] a tool pose must have come within, to start


class DemonstrationNode(TableNode):
    """Serves demonstration/{start,stop,discard,delete_last,rerecord_last}; publishes demonstration/{task,recorded}.

    ``demonstration/revise`` corrects one step of the task (mbd_msgs/ReviseTask).

    ``rerecord_last`` takes the last step away and records it again.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(DEMONSTRATION, **options)
        self._config = demonstration_config(self.values)
        self._finger_joints, state_dir = tuple(self.values["finger_joints"]), self.values["state_dir"]
        self._scene: Scene | None = None
        self._recording: Recording | None = None
        self._journal: Journal | None = None
        self._journal_file = Path(state_dir) / "demonstration.recording" if state_dir else None
        self._last_pose = -math.inf  # by the clock that never jumps
        self._last_pose_at: int | None = None  # by ROS time [ns]
        self._next_look = 0.0
        self._path: ToolTrajectory | None = None
        self._shown: tuple[tuple[TaskStep, ...], tuple[str, ...]] = ((), ())
        self._task = LatchedPublisher(self, TaskMsg, "demonstration/task", state_dir)
        self._recorded = self.create_publisher(TaskMsg, "demonstration/recorded", LATCHED)
        self.create_subscription(SceneMsg, "perception/source_scene", self._on_scene, LATCHED)
        self.create_subscription(PoseStamped, "j2n6s300_driver/out/tool_pose", self._on_pose, MOTION)
        self.create_subscription(JointState, "j2n6s300_driver/out/joint_state", self._on_joints, MOTION)
        self.create_subscription(WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may stand still or jump
        if self._config.gripper_source is GripperSource.JOINT:
            self.create_timer(JOINT_PERIOD, self._look, clock=steady)
        self.create_timer(JOURNAL_PERIOD, self._keep, clock=steady)
        for name, answer in (
            ("start", self._start),
            ("stop", self._stop),
            ("discard", self._discard),
            ("delete_last", self._delete_last),
            ("rerecord_last", self._rerecord_last),
        ):
            self.create_service(Trigger, f"demonstration/{name}", self._answering(answer))
        self.create_service(ReviseTask, "demonstration/revise", self._on_revise)

        self._go_on()

    def _now(self) -> float:
        return clock_seconds(self.get_clock())

    def _answering(self, answer: Callable[[], str]) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        """A service callback: ``answer()`` returns the sentence of success or raises MbdError with why not."""

        def callback(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.message, response.success = answered(self, answer)
            return response

        return callback

    def _on_scene(self, msg: SceneMsg) -> None:
        try:
            self._scene = scene_from_msg(msg)
        except MbdError as error:
            self.get_logger().error(f"perception/source_scene is unusable, the one before stays: {error}")

    def _on_pose(self, msg: PoseStamped) -> None:
        self._last_pose = time.monotonic()
        self._last_pose_at = self.get_clock().now().nanoseconds
        if self._recording:
            p, q = msg.pose.position, msg.pose.orientation
            stamp = time_from_msg(msg.header.stamp)
            self._recording.add_pose(stamp, msg.header.frame_id, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w), self._last_pose)

    def _on_joints(self, msg: JointState) -> None:
        if not self._recording:
            return
        new = self._recording.add_joints(time_from_msg(msg.header.stamp), msg.name, msg.position, time.monotonic())
        if new:
            how = "as finger_joints names them" if set(new) & set(self._finger_joints) else "by their names"
            self.get_logger().info(f"finger joints found {how}: {', '.join(new)}")

    def _on_gripper(self, msg: WizardGripper) -> None:
        if not self._recording or self._config.gripper_source is not GripperSource.SPOKEN:
            return
        if msg.command not in (WizardGripper.OPEN, WizardGripper.CLOSE):
            self.get_logger().warning(
                f"wizard/gripper command {msg.command} is neither OPEN (1) nor CLOSE (2): ignored"
            )
            return
        self._recording.add_event(
            GripperEvent(time_from_msg(msg.header.stamp) or self._now(), GripperAction(msg.command))
        )
        self._publish_recorded()

    def _look(self) -> None:
        """Look at what the joint shows, at most so often that it costs a small share of one core."""
        now = time.monotonic()
        if now < self._next_look:
            return
        before = time.process_time()
        self._publish_recorded()
        self._next_look = now + (time.process_time() - before) / LOOK_SHARE

    def _keep(self) -> None:
        """Have on disk what was recorded."""
        if self._recording and self._journal:
            try:
                self._journal.append(self._recording)
            except OSError as error:
                self.get_logger().error(
                    f"what is recorded cannot be kept in {self._journal.path}: {error}", throttle_duration_sec=5.0
                )

    def _go_on(self) -> None:
        """Go on with a recording that was cut off by the end of this node's process."""
        if not self._journal_file:
            return
        try:
            cut = cut_off(self._journal_file, self._finger_joints)
        except MbdError as error:
            self.get_logger().error(str(error))
            return
        if cut is None:
            return
        recording, task, again = cut
        self._scene = task.source
        self._begin(recording, task, again=again)
        self.get_logger().warning(
            f"a recording begun {self._now() - recording.begin:.1f} s ago was cut off with {len(recording.poses)} tool "
            "poses and goes on now: stop it, discard it, or start again"
        )

    def _publish_recorded(self) -> None:
        """Show the steps so far, when they are others than those shown last."""
        if not self._recording:
            return
        try:
            task = self._recording.task(self._now(), self._config, look=True)
        except MbdError as error:
            self.get_logger().warning(f"no steps to show yet: {error}", throttle_duration_sec=5.0)
            return
        if (task.steps, task.problems) != self._shown:
            self._shown = (task.steps, task.problems)
            self._recorded.publish(task_to_msg(task))

    def _begin(self, recording: Recording, task: Task, *, again: int) -> None:
        """Record, and show what is there to begin with: no steps, or those of ``task`` that are kept."""
        self._recording = recording
        if self._journal_file:
            self._journal_file.parent.mkdir(parents=True, exist_ok=True)
            self._journal = Journal.begin(self._journal_file, recording, serialize_message(task_to_msg(task)), again)
            self._keep()
        kept = recording.so_far
        self._shown = (kept.steps, kept.problems) if kept else ((), ())
        self._recorded.publish(task_to_msg(Task(recording.scene, *self._shown, recording.begin)))

    def _start(self) -> str:
        if self._scene is None:
            raise MbdError("no source scene yet: observe the source objects first (is the perception node running?)")
        self._require_pose()
        before, now = self._recording, self._now()
        self._begin(Recording(self._scene, now, wanted=self._finger_joints), Task(self._scene, ()), again=-1)
        dropped = f"; the recording begun {now - before.begin:.1f} s ago was discarded" if before else ""
        return f"recording over a source scene of {len(self._scene.objects)} objects{dropped}"

    def _require_pose(self) -> None:
        """Raise MbdError where no tool pose comes: nothing could be recorded."""
        ago = time.monotonic() - self._last_pose
        # While a simulated clock stands (a teacher waits for the operator) the arm has nothing to publish.
        at = self._last_pose_at
        passed = math.inf if at is None else to_seconds(self.get_clock().now().nanoseconds - at)
        if min(ago, passed) <= POSE_LATEST:
            return
        when = "none came since this node started" if math.isinf(ago) else f"the last one came {ago:.1f} s ago"
        raise MbdError(
            f"no tool pose comes on {self.resolve_topic_name('j2n6s300_driver/out/tool_pose')} ({when}), so nothing "
            "could be recorded: is the robot's driver (or the cell) running?"
        )

    def _end(self) -> None:
        """Nothing is recorded any more."""
        self._recording = None
        if self._journal:
            self._journal.end()
            self._journal = None

    def _stop(self) -> str:
        if self._recording is None:
            raise MbdError("no demonstration is being recorded: start one first")
        recording = self._recording
        self._end()
        task = recording.task(self._now(), self._config)
        self._path = recording.trajectory()[0]
        if not task.steps:
            raise MbdError("no step was demonstrated: " + "; ".join(task.problems))
        self._task.publish(task_to_msg(task))
        return " ".join([f"{len(task.steps)} steps recorded.", *(f"Note: {p}." for p in task.problems)])

    def _discard(self) -> str:
        had = self._recording
        self._end()
        return "recording discarded" if had else "nothing was being recorded"

    def _delete_last(self) -> str:
        if self._recording is not None:
            raise MbdError("a demonstration is being recorded: stop it before dropping its last step")
        if self._task.last is None:
            raise MbdError("there is no step to drop: no demonstration was recorded")
        task = task_from_msg(self._task.last)
        self._task.publish(task_to_msg(without_last_step(task, self._now())))
        step = task.steps[-1]
        return f"deleted step {step.index + 1}, {step.kind.name} {step.primary_object}; {step.index} steps left"

    def _on_revise(self, request: ReviseTask.Request, response: ReviseTask.Response) -> ReviseTask.Response:
        response.message, response.success = answered(self, lambda: self._revise(request))
        return response

    def _revise(self, request: ReviseTask.Request) -> str:
        """Correct one step of the task, and publish it."""
        if self._recording is not None:
            raise MbdError("a demonstration is being recorded: stop it before correcting its steps")
        if self._task.last is None:
            raise MbdError("there is no step to correct: no demonstration was recorded")
        task, index = task_from_msg(self._task.last), int(request.step)
        if request.change == ReviseTask.Request.RERECORD:
            self._require_pose()
            kept = shown_again_from(task, index)
            recording = Recording(task.source, self._now(), kept, self._finger_joints)
            self._task.publish(task_to_msg(replace(task, steps=kept.steps, problems=kept.problems, open_ends=())))
            self._begin(recording, task, again=index)
            return f"{kept.problems[-1]}: show them again, then stop"
        revised = corrected(task, request, self._now(), self._path)
        self._task.publish(task_to_msg(revised))
        return f"{revised.problems[-1]}; {len(revised.steps)} steps now"

    def _rerecord_last(self) -> str:
        task = task_from_msg(self._task.last) if self._task.last else None
        deleted = self._delete_last()
        if task is not None:
            recording = Recording(task.source, self._now(), redo_from(task), self._finger_joints)
            self._begin(recording, task, again=len(task.steps) - 1)
        return f"{deleted}; recording again: show it again, then stop"


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("demonstration", DemonstrationNode)
