"""The demonstration node: records the tool and the gripper, publishes the task they show, and corrects it."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.ros.conversions import (
    clock_seconds,
    correction_from_msg,
    scene_from_msg,
    state_from_msg,
    task_from_msg,
    task_to_msg,
    time_from_msg,
)
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.polling.subscriptions import subscribe_polled
from mbd_model.ros.qos import EVENTS, LATCHED, MOTION
from mbd_model.ros.run_node import run_node
from mbd_model.ros.stop_line import StopLine
from mbd_model.ros.word_check import WordCheck
from mbd_model.task import Task
from mbd_model.times import to_seconds
from mbd_msgs.msg import Scene as SceneMsg
from mbd_msgs.msg import SessionState, WizardGripper
from mbd_msgs.msg import Task as TaskMsg
from mbd_msgs.srv import ReviseTask
from rclpy.clock import ROSClock
from sensor_msgs.msg import JointState

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording import GripperSource, Recording
from mbd_demonstration.revision.corrections import corrected
from mbd_demonstration.revision.resuming import redo_from, shown_again_from, without_last_step
from mbd_demonstration.ros.motion_bytes import JointStateReader, pose_from_bytes
from mbd_demonstration.ros.running_recording import RunningRecording
from mbd_demonstration.ros.services import answered, serve_trigger

POSE_LATEST = 2.0  # [s] a tool pose must have come within, to start
MOTION_PERIOD = 0.05  # [s] between two looks at what poses and joint states have come
CLOCK_READ = 0.02  # [s] between two readings of ROS's clock while poses come


class DemonstrationNode(TableNode):
    """Serves demonstration/{start,stop,discard,delete_last,rerecord_last}; publishes demonstration/{task,recorded}.

    ``demonstration/revise`` corrects one step of the task (mbd_msgs/ReviseTask).

    ``rerecord_last`` takes the last step away and records it again.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(DEMONSTRATION, **options)
        config, state_dir = demonstration_config(self.values), self.values["state_dir"]
        self._spoken = config.gripper_source is GripperSource.SPOKEN
        self._finger_joints = tuple(self.values["finger_joints"])
        self._scene: Scene | None = None
        self._last_pose = -math.inf  # by the clock that never jumps
        self._last_pose_at: int | None = None  # by ROS time [ns]
        self._began_at = 0  # by ROS time [ns]; 0: no simulated time came yet
        self._task = LatchedPublisher(self, TaskMsg, "demonstration/task", state_dir)
        self._recording = RunningRecording(self, config, self._finger_joints, state_dir)
        self.create_subscription(SceneMsg, "perception/source_scene", self._on_scene, LATCHED)
        self._joint_states = JointStateReader()
        polled = partial(subscribe_polled, self, qos=MOTION, period=MOTION_PERIOD, raw=True)
        polled(PoseStamped, self.values["tool_pose"], self._on_pose)
        polled(JointState, self.values["joint_state"], self._on_joints)
        self._words = WordCheck(self, "wizard/gripper")
        self._stop_line = StopLine(self, serve=False)  # demonstration/stop ends a recording
        self._ended = False  # the task is that of the last recording, which was stopped
        self.create_subscription(WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)
        self.create_subscription(SessionState, "interaction/state", self._on_state, LATCHED)
        for name, answer in (
            ("start", self._start),
            ("stop", self._stop),
            ("discard", self._discard),
            ("delete_last", self._delete_last),
            ("rerecord_last", self._rerecord_last),
        ):
            serve_trigger(self, f"demonstration/{name}", answer)
        self.create_service(ReviseTask, "demonstration/revise", self._on_revise)
        self._recording.go_on()
        if self._recording.now:
            self._scene = self._recording.now.scene

    @property
    def recording(self) -> Recording | None:
        """What is recorded so far; None while nothing is."""
        return self._recording.now

    @property
    def scene(self) -> Scene | None:
        """The source scene a recording would be over."""
        return self._scene

    @property
    def last_pose(self) -> float:
        """When the last tool pose came, by the clock that never jumps [s]."""
        return self._last_pose

    def _now(self) -> float:
        return clock_seconds(self.get_clock())

    def _on_scene(self, msg: SceneMsg) -> None:
        self._scene = scene_from_msg(msg)

    def _on_pose(self, data: bytes) -> None:
        now = time.monotonic()
        if now - self._last_pose > CLOCK_READ or self._last_pose_at is None:
            self._last_pose_at = self.get_clock().now().nanoseconds
        self._last_pose = now
        if self.recording:
            self.recording.add_pose(*pose_from_bytes(data), self._last_pose)

    def _on_joints(self, data: bytes) -> None:
        if not self.recording:
            return
        new = self.recording.add_joints(*self._joint_states.read(data), time.monotonic())
        if new:
            how = "as finger_joints names them" if set(new) & set(self._finger_joints) else "by their names"
            self.get_logger().info(f"finger joints found {how}: {', '.join(new)}")

    def _on_gripper(self, msg: WizardGripper) -> None:
        self._words.count()
        if msg.command not in (WizardGripper.OPEN, WizardGripper.CLOSE):
            raise MbdError(f"command {msg.command} is neither OPEN (1) nor CLOSE (2)")
        if self._stop_line.latch.held:
            self.get_logger().warning(f"wizard/gripper is no event of the demonstration: {self._stop_line.why}")
        elif self.recording and self._spoken:
            stamp = time_from_msg(msg.header.stamp) or self._now()
            self._recording.add_word(GripperEvent(stamp, GripperAction(msg.command)))

    def _on_state(self, msg: SessionState) -> None:
        if self._spoken:
            words = state_from_msg(msg).words
            actions = (GripperAction.CLOSE if w.close else GripperAction.OPEN for w in words)
            self._recording.add_missed(GripperEvent(w.stamp, a) for w, a in zip(words, actions, strict=True))

    def _start(self) -> str:
        if self._scene is None:
            raise MbdError("no source scene yet: observe the source objects first (is the perception node running?)")
        self._require_pose()
        before, now = self.recording, self._now()
        new = Recording(self._scene, now, wanted=self._finger_joints)
        self._recording.begin(new, Task(self._scene, ()), again=-1)
        self._ended = False
        dropped = f"; the recording begun {now - before.begin:.1f} s ago was discarded" if before else ""
        return f"recording over a source scene of {len(self._scene.objects)} objects{dropped}"

    def _require_pose(self) -> None:
        """Raise MbdError where no tool pose comes: nothing could be recorded."""
        ago = time.monotonic() - self._last_pose
        if min(ago, self._simulated_since_pose()) <= POSE_LATEST:
            return
        when = "none came since this node started" if math.isinf(ago) else f"the last one came {ago:.1f} s ago"
        raise MbdError(
            f"no tool pose comes on {self.resolve_topic_name(self.values['tool_pose'])} ({when}), so nothing "
            "could be recorded: is the robot's driver (or the cell) running?"
        )

    def _simulated_since_pose(self) -> float:
        """Simulated seconds since the last tool pose, or this node's beginning, while somebody publishes them.

        While a simulated clock stands, as a teacher waits for the operator, the arm has nothing to publish: a node that
        came back just then would refuse what the clock waits for.
        """
        clock, topic = self.get_clock(), self.resolve_topic_name(self.values["tool_pose"])
        if not (isinstance(clock, ROSClock) and clock.ros_time_is_active) or not self.count_publishers(topic):
            return math.inf
        now = clock.now().nanoseconds
        self._began_at = self._began_at or now
        return to_seconds(now - (self._began_at if self._last_pose_at is None else self._last_pose_at))

    def _stop(self) -> str:
        if self.recording is None and self._ended and self._task.last is not None:
            # Who asked before was killed with the answer on its way: the demonstration need not be shown again.
            msg = self._task.last
            task = task_from_msg(msg)
        else:
            task = self._recording.complete()
            msg = task_to_msg(task)
            self._ended = True
        self._task.publish(msg)
        return " ".join([f"{len(task.steps)} steps recorded.", *(f"Note: {p}." for p in task.problems)])

    def _discard(self) -> str:
        self._ended = False
        return "recording discarded" if self._recording.discard() else "nothing was being recorded"

    def _recorded_task(self, to_do: str) -> Task:
        """The task, to be corrected; raises MbdError while there is none, or another is recorded."""
        if self.recording is not None:
            raise MbdError(f"a demonstration is being recorded: stop it before {to_do}")
        if self._task.last is None:
            raise MbdError(f"{to_do} needs a task: no demonstration was recorded")
        return task_from_msg(self._task.last)

    def _delete_last(self) -> str:
        task = self._recorded_task("dropping its last step")
        self._task.publish(task_to_msg(without_last_step(task, self._now())))
        step = task.steps[-1]
        return f"deleted step {step.index + 1}, {step.kind.name} {step.primary_object}; {step.index} steps left"

    def _rerecord_last(self) -> str:
        task = self._recorded_task("recording its last step again")
        deleted = self._delete_last()
        recording = Recording(task.source, self._now(), redo_from(task), self._finger_joints)
        self._recording.begin(recording, task, again=len(task.steps) - 1)
        self._ended = False
        return f"{deleted}; recording again: show it again, then stop"

    def _on_revise(self, request: ReviseTask.Request, response: ReviseTask.Response) -> ReviseTask.Response:
        response.message, response.success = answered(self, lambda: self._revise(request))
        return response

    def _revise(self, request: ReviseTask.Request) -> str:
        """Correct one step of the task, and publish it."""
        task = self._recorded_task("correcting its steps")
        correction = correction_from_msg(request)
        if correction.kind is CorrectionKind.RERECORD:
            return self._record_again(task, correction)
        path = self._recording.path_of(task) if correction.kind is CorrectionKind.SPLIT else None
        revised = corrected(task, correction, self._now(), path)
        self._task.publish(task_to_msg(revised))
        return f"{revised.problems[-1]}; {len(revised.steps)} steps now"

    def _record_again(self, task: Task, correction: StepCorrection) -> str:
        self._require_pose()
        kept = shown_again_from(task, correction.step)
        recording = Recording(task.source, self._now(), kept, self._finger_joints)
        self._task.publish(task_to_msg(replace(task, steps=kept.steps, problems=kept.problems, open_ends=())))
        self._recording.begin(recording, task, again=correction.step)
        self._ended = False
        return f"{kept.problems[-1]}: show them again, then stop"


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("demonstration", DemonstrationNode)
