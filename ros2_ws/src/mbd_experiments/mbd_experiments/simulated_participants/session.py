"""One simulated participant's whole session, in process: rendered RGB-D to assists, by the algorithms of every package.

The same functions that the nodes call, without a ROS graph: the cell ticks as fast as it can, perception sees the
frames it renders, the demonstration is read off its tool poses, the dialogue asks, the participant answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_cell.cell import START_NS, Cell
from mbd_cell.physics.camera import INTRINSICS, Camera, Frame
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.stage import Stage
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.recording import DemonstrationConfig, Recording
from mbd_interaction.dialogue import Request
from mbd_interaction.events import Answered, Event, Gripped, Signal, TaskReceived
from mbd_mapping.config import MappingConfig
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.session import Phase
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.frame import RgbdFrame, fuse, make_frame

from mbd_experiments.simulated_participants.answering import Answering
from mbd_experiments.simulated_participants.dialogue_loop import DialogueLoop, MappingSettings, Result, Tape
from mbd_experiments.simulated_participants.script import ParticipantScript

POSE_TICKS = 3  # 30 ms between two tool poses, as the cell node has it
FRAMES, FRAME_TICKS = 3, 25  # frames of an observation, 0.25 s apart
PATIENCE_TICKS = 60_000  # 10 min: no phase of a session is as long
THINKING = (1.5, 4.0)  # [s] between a question and its answer
THINKING_STREAM = 12


class SessionEndedError(MbdError):
    """The session cannot go on. The text says in which phase and why."""


@dataclass(frozen=True)
class Settings:
    """What every session of a study shares.

    Attributes:
        perception: how scenes are seen.
        mapping: how mappings are inferred.
        threshold: below which confidence the robot asks on; 1 asks about every object, as the paper's study did.
    """

    perception: ObserveConfig
    mapping: MappingConfig
    threshold: float = 1.0


class ParticipantSession:
    """Runs one session to its end."""

    def __init__(self, name: str, script: ParticipantScript, seed: int, settings: Settings, tape: Tape) -> None:
        self._settings, self._tape = settings, tape
        self._cell = Cell(script.scenes, seed, CELL_CAMERA)
        self._stage = Stage(self._cell, teaches=True)
        self._rng = np.random.default_rng([seed, THINKING_STREAM])
        self._source: Scene | None = None
        self._recording: Recording | None = None
        self._answering = Answering(script)
        self._words: list[Word] = []
        self._ticks = 0
        self._table_told = -1
        self._loop = DialogueLoop(
            name, self._do, lambda: self._cell.time_ns, tape, MappingSettings(settings.mapping, settings.threshold)
        )

    def run(self) -> Phase:
        """The whole session; returns the phase it ended in, DONE unless the dialogue was aborted.

        Raises:
            SessionEndedError: a phase that does not come to its end.
            MbdError: the cell, perception or demonstration cannot do what it should.
        """
        self._lay(Phase.OBSERVE_SOURCE)
        self._command()
        self._demonstrate()
        self._lay(Phase.TUCK_AND_CLEAR)
        self._command()
        self._enter(Phase.OBSERVE_TARGET)
        self._command()
        while self._phase is Phase.ASSIST:
            self._pass_time(float(self._rng.uniform(*THINKING)))
            self._answer()
        self._command()
        return self._phase

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return (self._cell.time_ns - START_NS) / 1e9

    @property
    def _phase(self) -> Phase:
        return self._loop.dialogue.phase

    @property
    def _now(self) -> int:
        return self._cell.time_ns

    def _enter(self, phase: Phase) -> None:
        if self._phase is not phase:
            raise SessionEndedError(f"the session stays in {self._phase.name} instead of {phase.name}: {self._detail}")
        self._stage.enter(phase)

    @property
    def _detail(self) -> str:
        return self._loop.dialogue.detail

    def _lay(self, phase: Phase) -> None:
        """Wait until the experimenter has laid the table."""
        self._enter(phase)
        self._until(Word.READY)
        self._stage.heard(Word.READY)

    def _command(self) -> None:
        self._tape.write("wizard/command", Signal.NEXT_PHASE, self._now)
        reply = self._loop.feed(Event(Signal.NEXT_PHASE, self._now, "wizard/command"))
        if reply is None or not reply.accepted:
            raise SessionEndedError(f"the session cannot leave {self._phase.name}: {reply.reason if reply else ''}")

    def _demonstrate(self) -> None:
        self._enter(Phase.DEMONSTRATE)
        while self._phase is Phase.DEMONSTRATE:
            word = self._until(*ANSWERED_BY_GRIPPER, Word.DEMONSTRATION_BEGINS, Word.DEMONSTRATION_ENDS)
            if word in ANSWERED_BY_GRIPPER:
                self._grip(word)
                continue
            begins = word is Word.DEMONSTRATION_BEGINS
            signal = Signal.START if begins else Signal.STOP
            self._tape.write("wizard/demonstration", signal, self._now)
            reply = self._loop.feed(Event(signal, self._now, "wizard/demonstration"))
            if reply is None or not reply.accepted:
                raise SessionEndedError(f"the demonstration failed: {reply.reason if reply else 'no reply'}")
            if begins:
                self._stage.begin()
        self._recording = None

    def _grip(self, word: Word) -> None:
        command = ANSWERED_BY_GRIPPER[word]
        self._tape.write("wizard/gripper", command, self._now)
        if self._recording is not None:
            self._recording.add_event(GripperEvent(self._now / 1e9, GripperAction(int(command))))
        self._loop.feed(Gripped(Signal.GRIPPER, self._now, "wizard/gripper", word is Word.CLOSE))
        self._stage.gripper(command)

    def _answer(self) -> None:
        """The teacher answers the question asked; the operator skips it when there is no answer."""
        dialogue = self._loop.dialogue
        if dialogue.step_index < 0:
            raise SessionEndedError(f"the robot asks nothing and does not go on either: {dialogue.detail}")
        for target in self._answering.answers(dialogue):
            signal = self._answering.signal(dialogue)
            self._tape.write(f"wizard/{signal}", target, self._now)
            reply = self._loop.feed(Answered(signal, self._now, f"wizard/{signal}", target))
            if reply is not None and reply.accepted:
                return
            self._pass_time(1.0)
        self._tape.write("wizard/command", Signal.SKIP, self._now)
        self._loop.feed(Event(Signal.SKIP, self._now, "wizard/command"))

    def _do(self, request: Request) -> Result:
        """A request of the dialogue, as the nodes do it."""
        try:
            if request in (Request.OBSERVE_SOURCE, Request.OBSERVE_TARGET):
                return self._observe(Role.SOURCE if request is Request.OBSERVE_SOURCE else Role.TARGET)
            if request is Request.START and self._source is not None:
                self._recording = Recording(self._source, self._now / 1e9)
                return Result(True, f"recording over a source scene of {len(self._source.objects)} objects")
            if request is Request.STOP and self._recording is not None:
                task = self._recording.task(self._now / 1e9, DemonstrationConfig())
                if not task.steps:
                    return Result(False, "no step was demonstrated: " + "; ".join(task.problems))
                self._tape.write("demonstration/task", task, self._now)
                heard = TaskReceived(Signal.TASK, self._now, task=task, stamp=round(task.stamp * 1e9))
                return Result(True, f"{len(task.steps)} steps recorded", heard=(heard,))
        except MbdError as error:
            return Result(False, str(error))
        return Result(False, f"cannot {request} now")

    def _observe(self, role: Role) -> Result:
        with Camera(self._cell.model) as camera:
            frames = []
            for _ in range(FRAMES):
                self._pass_time(FRAME_TICKS / 100)
                frame = camera.render(self._cell.simulation, self._cell.image_rng())
                self._tape.write("camera", frame, self._now)
                frames.append(rgbd(frame, self._now / 1e9))
        seen = observe(fuse(frames), role, CELL_CAMERA, self._settings.perception)
        self._tape.write(f"perception/{role}_scene", (seen.scene, seen.table_in_base), self._now)
        self._answering.see(seen.scene, self._cell)
        if role is Role.SOURCE:
            self._source = seen.scene
        return Result(True, seen.summary, seen.scene if role is Role.TARGET else None)

    def _until(self, *wanted: Word) -> Word:
        """Let time pass until one of the words is said."""
        for _ in range(PATIENCE_TICKS):
            while self._words:
                word = self._words.pop(0)
                if word in wanted:
                    return word
            self._tick()
        raise SessionEndedError(
            f"in {self._phase.name} nobody said any of {[w.name for w in wanted]} within 10 minutes"
        )

    def _pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds * 100)):
            self._tick()

    def _tick(self) -> None:
        passed = self._stage.tick()
        if self._cell.generation != self._table_told:
            self._table_told = self._cell.generation
            self._tape.write("cell/truth", self._cell, self._now)
        for word in self._stage.take_words():
            self._tape.write("cell/speech", word, self._now)
            self._words.append(word)
        if passed:
            self._ticks += 1
        if passed and self._recording is not None and self._ticks % POSE_TICKS == 0:
            tool = self._cell.simulation.tool
            self._recording.add_pose(self._now / 1e9, self._recording.scene.frame_id, tool.position, tool.quaternion)
            self._tape.write("robot", self._cell, self._now)


def rgbd(frame: Frame, stamp: float) -> RgbdFrame:
    """A rendered frame as perception takes it, depth in whole millimetres as a camera gives it."""
    return make_frame(frame.color, frame.depth_mm, INTRINSICS, stamp)
