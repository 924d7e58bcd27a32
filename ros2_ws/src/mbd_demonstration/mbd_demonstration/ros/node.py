"""The demonstration node: records the tool and the gripper, publishes the task they show."""

from __future__ import annotations

from collections.abc import Callable
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
from mbd_msgs.msg import Scene as SceneMsg
from mbd_msgs.msg import Task as TaskMsg
from mbd_msgs.msg import WizardGripper
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording import GripperSource, Recording
from mbd_demonstration.revision import redo_from, without_last_step

JOINT_PERIOD = 1.0  # [s] between two looks at what the finger joint shows so far


class DemonstrationNode(TableNode):
    """Serves demonstration/{start,stop,discard,delete_last,rerecord_last}; publishes demonstration/{task,recorded}.

    ``rerecord_last`` takes the last step away and records it again.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(DEMONSTRATION, **options)
        self._config = demonstration_config(self.values)
        self._finger_joints, state_dir = self.values["finger_joints"], self.values["state_dir"]
        self._scene: Scene | None = None
        self._recording: Recording | None = None
        self._shown: tuple[tuple[TaskStep, ...], tuple[str, ...]] = ((), ())
        self._task = LatchedPublisher(self, TaskMsg, "demonstration/task", state_dir)
        self._recorded = self.create_publisher(TaskMsg, "demonstration/recorded", LATCHED)
        self.create_subscription(SceneMsg, "perception/source_scene", self._on_scene, LATCHED)
        self.create_subscription(PoseStamped, "j2n6s300_driver/out/tool_pose", self._on_pose, MOTION)
        self.create_subscription(JointState, "j2n6s300_driver/out/joint_state", self._on_joints, MOTION)
        self.create_subscription(WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)
        if self._config.gripper_source is GripperSource.JOINT:
            self.create_timer(JOINT_PERIOD, self._publish_recorded)
        for name, answer in (
            ("start", self._start),
            ("stop", self._stop),
            ("discard", self._discard),
            ("delete_last", self._delete_last),
            ("rerecord_last", self._rerecord_last),
        ):
            self.create_service(Trigger, f"demonstration/{name}", self._answering(answer))

    def _now(self) -> float:
        return clock_seconds(self.get_clock())

    def _answering(self, answer: Callable[[], str]) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        """A service callback: ``answer()`` returns the sentence of success or raises MbdError with why not."""

        def callback(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            try:
                response.message, response.success = answer(), True
            except MbdError as error:
                response.message, response.success = str(error), False
                self.get_logger().warning(str(error))
            else:
                self.get_logger().info(response.message)
            return response

        return callback

    def _on_scene(self, msg: SceneMsg) -> None:
        try:
            self._scene = scene_from_msg(msg)
        except MbdError as error:
            self.get_logger().error(f"perception/source_scene is unusable, the one before stays: {error}")

    def _on_pose(self, msg: PoseStamped) -> None:
        if self._recording:
            p, q = msg.pose.position, msg.pose.orientation
            self._recording.add_pose(
                time_from_msg(msg.header.stamp), msg.header.frame_id, (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
            )

    def _on_joints(self, msg: JointState) -> None:
        if self._recording and self._config.gripper_source is GripperSource.JOINT:
            at = [msg.position[msg.name.index(j)] for j in self._finger_joints if j in msg.name]
            if len(at) == len(self._finger_joints):
                self._recording.add_finger(time_from_msg(msg.header.stamp), sum(at) / len(at))

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

    def _publish_recorded(self) -> None:
        """Show the steps so far, when they are others than those shown last."""
        if not self._recording:
            return
        try:
            task = self._recording.task(self._now(), self._config)
        except MbdError as error:
            self.get_logger().warning(f"no steps to show yet: {error}", throttle_duration_sec=5.0)
            return
        if (task.steps, task.problems) != self._shown:
            self._shown = (task.steps, task.problems)
            self._recorded.publish(task_to_msg(task))

    def _begin(self, recording: Recording) -> None:
        """Record, and show what is there to begin with: no steps, or those that are kept."""
        self._recording = recording
        kept = recording.so_far
        self._shown = (kept.steps, kept.problems) if kept else ((), ())
        self._recorded.publish(task_to_msg(Task(recording.scene, *self._shown, recording.begin)))

    def _start(self) -> str:
        if self._scene is None:
            raise MbdError("no source scene yet: observe the source objects first (is the perception node running?)")
        before, now = self._recording, self._now()
        self._begin(Recording(self._scene, now))
        dropped = f"; the recording begun {now - before.begin:.1f} s ago was discarded" if before else ""
        return f"recording over a source scene of {len(self._scene.objects)} objects{dropped}"

    def _stop(self) -> str:
        if self._recording is None:
            raise MbdError("no demonstration is being recorded: start one first")
        recording, self._recording = self._recording, None
        task = recording.task(self._now(), self._config)
        if not task.steps:
            raise MbdError("no step was demonstrated: " + "; ".join(task.problems))
        self._task.publish(task_to_msg(task))
        return " ".join([f"{len(task.steps)} steps recorded.", *(f"Note: {p}." for p in task.problems)])

    def _discard(self) -> str:
        had, self._recording = self._recording, None
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

    def _rerecord_last(self) -> str:
        task = task_from_msg(self._task.last) if self._task.last else None
        deleted = self._delete_last()
        if task is not None:
            self._begin(Recording(task.source, self._now(), redo_from(task)))
        return f"{deleted}; recording again: show it again, then stop"


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("demonstration", DemonstrationNode)
