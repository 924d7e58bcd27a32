"""The recording that runs: shown on a topic while it does, and on disk so that a killed node finds it again."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.folders import set_aside
from mbd_model.ros.conversions import clock_seconds, task_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_model.task import Task, TaskStep
from mbd_msgs.msg import Task as TaskMsg
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.serialization import serialize_message

from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.interruption import cut_off_notes, gaps, received_before
from mbd_demonstration.journal import Journal
from mbd_demonstration.recording import DemonstrationConfig, GripperSource, Recording
from mbd_demonstration.ros.kept_recordings import kept_path, kept_recording
from mbd_demonstration.trajectory import ToolTrajectory

JOINT_PERIOD = 1.0  # [s] between two looks at what the finger joint shows so far
LOOK_SHARE = 0.03  # of a core that looks may take
JOURNAL_PERIOD = 0.5  # [s] between two writes of what is recorded


class RunningRecording:
    """Holds one recording at a time for a node.

    Args:
        node: whose topic and timers they are.
        config: what decides how a recording becomes a task.
        wanted: names of the finger joints.
        state_dir: folder that keeps it over a restart; "" keeps nothing.

    Attributes:
        now: the recording that runs, None while there is none.
    """

    def __init__(self, node: Node, config: DemonstrationConfig, wanted: tuple[str, ...], state_dir: str) -> None:
        self._node, self._config, self._wanted = node, config, wanted
        self.now: Recording | None = None
        self._journal: Journal | None = None
        self._file = Path(state_dir) / "demonstration.recording" if state_dir else None
        self._path: tuple[float, ToolTrajectory] | None = None  # with the stamp of the scene it was recorded over
        self._cuts: tuple[float, ...] = ()  # last tool pose before each end of a node that recorded it [s]
        self._next_look = 0.0
        self._shown: tuple[tuple[TaskStep, ...], tuple[str, ...]] = ((), ())
        self._recorded = node.create_publisher(TaskMsg, "demonstration/recorded", LATCHED)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # simulated time may stand still or jump
        if config.gripper_source is GripperSource.JOINT:
            node.create_timer(JOINT_PERIOD, self._look, clock=steady)
        node.create_timer(JOURNAL_PERIOD, self._keep, clock=steady)

    def begin(self, recording: Recording, task: Task, *, again: int, cuts: tuple[float, ...] = ()) -> None:
        """Record, and show what is there to begin with: no steps, or those of ``task`` that are kept.

        Args:
            recording: that begins.
            task: it begins from.
            again: first of its steps that are shown again (0-based), -1 for none.
            cuts: last tool pose before each end of a node that recorded it [s].
        """
        self.now, self._cuts = recording, cuts
        if self._file:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            self._journal = Journal.begin(self._file, recording, serialize_message(task_to_msg(task)), again, cuts)
            self._keep()
        kept = recording.so_far
        self._shown = (kept.steps, kept.problems) if kept else ((), ())
        self._recorded.publish(task_to_msg(Task(recording.scene, *self._shown, recording.begin)))

    def discard(self) -> bool:
        """Record nothing any more; returns whether there was a recording."""
        had, self.now = self.now, None
        if self._journal:
            self._journal.end()
            self._journal = None
        return had is not None

    def complete(self) -> Task:
        """End the recording and return its task; raises MbdError when none was demonstrated, or none ran."""
        recording, journal = self.now, self._journal
        if recording is None:
            raise MbdError("no demonstration is being recorded: start one first")
        try:
            task = recording.task(self._time(), self._config)
            if not task.steps:
                raise MbdError("no step was demonstrated: " + "; ".join(task.problems))
            unseen = gaps(self._cuts, recording.poses.table()[:, 0])
            notes = cut_off_notes(task, recording.begin, unseen, recording.events)
            task = replace(task, problems=(*task.problems, *notes))
        except MbdError:
            self.discard()
            raise
        self.now, self._journal = None, None
        self._path = (recording.scene.stamp, recording.trajectory()[0])
        if journal:
            try:
                journal.complete(recording)
            except OSError as error:
                self._node.get_logger().error(f"the recording cannot be kept beside its task: {error}")
        return task

    def path_of(self, task: Task) -> ToolTrajectory | None:
        """Where the tool went as the task was recorded; None where that is no longer known."""
        if self._path is None and self._file:
            found = kept_path(self._file, task)
            self._path = (task.source.stamp, found) if found else None
        return self._path[1] if self._path and self._path[0] == task.source.stamp else None

    def go_on(self) -> None:
        """Go on with a recording that was cut off by the end of the node's process."""
        if not self._file:
            return
        try:
            cut = kept_recording(self._file, self._wanted)
        except MbdError as error:
            self._node.get_logger().error(f"{error}. {set_aside(self._file)}")
            return
        if cut is None:
            return
        recording, task, again, cuts = cut
        stamps = recording.poses.table()[:, 0]
        self.begin(recording, task, again=again, cuts=(*cuts, float(stamps.max()) if stamps.size else recording.begin))
        self._node.get_logger().warning(
            f"a recording begun {self._time() - recording.begin:.1f} s ago was cut off with {len(recording.poses)} "
            "tool poses and goes on now: stop it, discard it, or start again"
        )

    def add_word(self, event: GripperEvent) -> None:
        """Add a spoken gripper command; after a cut it may have come by the dialogue's state before."""
        if self.now and not (self._cuts and received_before(self.now.events, event)):
            self.now.add_event(event)
            self.publish()

    def add_missed(self, events: Iterable[GripperEvent]) -> None:
        """Add the gripper commands, as the dialogue keeps them, that came while no node was there to record them."""
        if not self.now or not self._cuts:
            return
        for event in events:
            if event.stamp >= self.now.begin and not received_before(self.now.events, event):
                self._node.get_logger().info(f"received {event.action.name} at {event.stamp - self.now.begin:.1f} s")
                self.add_word(event)

    def publish(self) -> None:
        """Show the steps so far, when they are others than those shown last."""
        if not self.now:
            return
        try:
            task = self.now.task(self._time(), self._config, look=True)
        except MbdError as error:
            self._node.get_logger().warning(f"no steps to show yet: {error}", throttle_duration_sec=5.0)
            return
        if (task.steps, task.problems) != self._shown:
            self._shown = (task.steps, task.problems)
            self._recorded.publish(task_to_msg(task))

    def _time(self) -> float:
        return clock_seconds(self._node.get_clock())

    def _look(self) -> None:
        """Look at what the joint shows, at most so often that it costs a small share of one core."""
        now = time.monotonic()
        if now < self._next_look:
            return
        before = time.process_time()
        self.publish()
        self._next_look = now + (time.process_time() - before) / LOOK_SHARE

    def _keep(self) -> None:
        """Have on disk what was recorded."""
        if self.now and self._journal:
            try:
                self._journal.append(self.now)
            except OSError as error:
                self._node.get_logger().error(
                    f"what is recorded cannot be kept in {self._journal.path}: {error}", throttle_duration_sec=5.0
                )
