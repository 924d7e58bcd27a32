"""A session of the simulated cell in this process: what the cell, perception and demonstration nodes do, as calls.

The same functions that the nodes call, without a ROS graph: the cell ticks as fast as it can, perception sees the
frames it renders, the demonstration is read off its tool poses. Who leads the session is another's: a simulated
participant by the dialogue (`simulated_participants`), or a trial that knows what comes next (`execution_trials`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from mbd_cell.cell import START_NS, Cell
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.physics.camera import INTRINSICS, Camera
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robots import JACO
from mbd_cell.stage import Stage
from mbd_cell.teacher.recognition import recognise
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording import Recording
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.task import Task
from mbd_model.times import to_seconds
from mbd_perception.features.measure import Observation, ObserveConfig, observe
from mbd_perception.frames.frame import fuse, make_frame

FINGER_JOINTS: tuple[str, ...] = tuple(DEMONSTRATION.values()["finger_joints"])
POSE_TICKS = 3  # 30 ms between two tool poses, as the cell node has it
FRAMES, FRAME_TICKS = 3, 25  # frames of an observation, 0.25 s apart
PATIENCE_TICKS = 60_000  # 10 min: no phase of a session is as long


class SessionEndedError(MbdError):
    """The session cannot go on. The text states in which phase and why."""


class Tape(Protocol):
    """Where everything that a node would have published goes."""

    def write(self, topic: str, value: Any, at: int) -> None:
        """Record a value of that topic at that time [ns]."""


class NoTape:
    """Keeps nothing."""

    def write(self, topic: str, value: Any, at: int) -> None:
        """Drop it."""


class InProcessSession:
    """A cell with one task's objects on its table, and what is seen and recorded in it.

    Args:
        scenes: of the task.
        seed: of layouts, the teacher's hand and the camera's noise.
        perception: how scenes are seen.
        tape: takes camera frames, robot states, words, truths and scenes.
        grasp: what keeps things in the hand.

    Attributes:
        cell: the cell.
        stage: to be informed in which phase the session is.
        watchers: called after each control tick that passed.
        fingers: the hand's joints are recorded with a demonstration, as a driver gives them.
        lateness: how late [s] the next word to the hand is entered.
    """

    def __init__(
        self,
        scenes: TaskScenes,
        seed: int,
        perception: ObserveConfig,
        tape: Tape | None = None,
        grasp: Grasp = Grasp.WELD,
    ) -> None:
        self.cell = Cell(scenes, seed, CELL_CAMERA, JACO, grasp)
        self.watchers: list[Callable[[], None]] = []
        self.fingers = False
        self.lateness: Callable[[], float] = _at_once
        self.stage = Stage(self.cell, teaches=True)
        self._perception, self._tape = perception, tape or NoTape()
        self._recording: Recording | None = None
        self._word_at = 0.0  # [s] of the last one entered; words are entered in their order
        self._words: list[Word] = []
        self._ticks = 0
        self._table_reported = -1

    @property
    def now(self) -> int:
        """Simulated time [ns]."""
        return self.cell.time_ns

    @property
    def seconds(self) -> float:
        """Simulated time since the session began [s]."""
        return to_seconds(self.cell.time_ns - START_NS)

    def observe(self, role: Role, frames: int = FRAMES, frame_ticks: int = FRAME_TICKS) -> Observation:
        """What perception sees of the table now, from several frames with the camera's noise, some ticks apart.

        Raises:
            MbdError: perception cannot read the table.
        """
        seen = self.look(role, frames, frame_ticks)
        self._tape.write(f"perception/{role}_scene", (seen.scene, seen.table_in_base), self.now)
        return seen

    def look(self, role: Role, frames: int = FRAMES, frame_ticks: int = FRAME_TICKS) -> Observation:
        """As ``observe``, for who looks again meanwhile: nothing is published as that set's scene."""
        with Camera(self.cell.model) as camera:
            taken = []
            for _ in range(frames):
                self.pass_time(frame_ticks / 100)
                frame = camera.render(self.cell.simulation, self.cell.image_rng())
                self._tape.write("camera", frame, self.now)
                # Depth in integer millimetres, as a camera gives it.
                taken.append(make_frame(frame.color, frame.depth_mm, INTRINSICS, to_seconds(self.now)))
        return observe(fuse(taken), role, CELL_CAMERA, self._perception)

    def true_names(self, scene: Scene) -> Mapping[str, str]:
        """True name by perceived id, by where the objects stand on the table now."""
        physics = self.cell.simulation
        return recognise(scene, {name: physics.object_pose(name).position[:2] for name in physics.objects})

    def start_recording(self, source: Scene) -> None:
        """Begin to record a demonstration over this scene."""
        self._recording = Recording(source, to_seconds(self.now), wanted=FINGER_JOINTS)
        self._word_at = 0.0

    def grip(self, word: Word) -> None:
        """Do with the hand what the teacher's word asks for, and record it."""
        command = ANSWERED_BY_GRIPPER[word]
        if self._recording is not None:
            at = max(to_seconds(self.now) + self.lateness(), self._word_at)
            self._word_at = at
            self._recording.add_event(GripperEvent(at, GripperAction(int(command))))
        self.stage.gripper(command)

    def stop_recording(self) -> Task:
        """The task as recorded; nothing more is.

        Raises:
            MbdError: nothing is being recorded, or no tool pose was.
        """
        if self._recording is None:
            raise MbdError("no demonstration is being recorded: start one first")
        recording, self._recording = self._recording, None
        return recording.task(to_seconds(self.now), demonstration_config(DEMONSTRATION.values()))

    def until(self, *wanted: Word) -> Word:
        """Let time pass until one of the words is spoken.

        Raises:
            SessionEndedError: none is spoken within 10 minutes.
        """
        for _ in range(PATIENCE_TICKS):
            while self._words:
                word = self._words.pop(0)
                if word in wanted:
                    return word
            self.tick()
        phase = self.stage.phase.name if self.stage.phase else "no phase"
        raise SessionEndedError(f"in {phase} nobody spoke any of {[w.name for w in wanted]} within 10 minutes")

    def pass_time(self, seconds: float) -> None:
        """Let time pass [s]."""
        for _ in range(round(seconds * 100)):
            self.tick()

    def tick(self) -> None:
        """Let 10 ms pass, if the teacher does not wait; what happens meanwhile goes on tape."""
        passed = self.stage.tick()
        if self.cell.generation != self._table_reported:
            self._table_reported = self.cell.generation
            self._tape.write("cell/truth", self.cell, self.now)
        for word in self.stage.take_words():
            self._tape.write("cell/speech", word, self.now)
            self._words.append(word)
        if passed:
            self._ticks += 1
        if passed and self._recording is not None and self._ticks % POSE_TICKS == 0:
            tool = self.cell.simulation.tool
            self._recording.add_pose(
                to_seconds(self.now), self._recording.scene.frame_id, tool.position, tool.quaternion
            )
            if self.fingers:
                joints = self.cell.simulation.finger_joints
                self._recording.add_joints(to_seconds(self.now), FINGER_JOINTS, [float(v) for v in joints])
            self._tape.write("robot", self.cell, self.now)
        if passed:
            for watch in self.watchers:
                watch()


def _at_once() -> float:
    """No word is late."""
    return 0.0
