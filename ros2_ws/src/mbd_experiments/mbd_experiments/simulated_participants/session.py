"""A simulated participant's session, in process: rendered RGB-D to assists, by the algorithms of every package.

The dialogue leads the session of the cell, asks, and the participant answers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from mbd_cell.outcome import ObjectState, object_states
from mbd_cell.physics.grasp import Grasp
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
from mbd_interaction.config import DialogueConfig
from mbd_interaction.effects import Request
from mbd_interaction.events import Answered, Event, Gripped, Signal, TaskReceived
from mbd_mapping.config import MappingConfig
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.session import Phase
from mbd_model.times import to_nanoseconds
from mbd_perception.features.measure import ObserveConfig

from mbd_experiments.in_process_session import InProcessSession, SessionEndedError, Tape
from mbd_experiments.simulated_participants.answering import Answering
from mbd_experiments.simulated_participants.dialogue_loop import DialogueLoop, MappingSettings, Result
from mbd_experiments.simulated_participants.script import ParticipantScript

THINKING = (1.5, 4.0)  # [s] between a question and its answer
THINKING_STREAM = 12
MAX_QUESTIONS = 60  # more than any session has questions


@dataclass(frozen=True)
class Settings:
    """What every session of a study shares.

    Attributes:
        perception: how scenes are seen.
        mapping: how mappings are inferred.
        threshold: below which confidence the robot asks on; 1 asks about every object, as the paper's study did.
        dialogue: how the dialogue behaves.
        grasp: what keeps things in the hand.
    """

    perception: ObserveConfig
    mapping: MappingConfig
    threshold: float = 1.0
    dialogue: DialogueConfig = field(default_factory=DialogueConfig)
    grasp: Grasp = Grasp.WELD


class ParticipantSession:
    """Runs one session to its end.

    Args:
        name: of the session.
        script: what the participant shows and means.
        seed: of layouts, the guiding hand, the camera's noise and thinking times.
        settings: what every session of a study shares.
        tape: takes everything that happens.
        answering: who answers the robot's questions; None: a participant by the script.

    Attributes:
        tape: takes everything that happens.
        cell_session: the cell's part of it.
        loop: the dialogue's.
        asked: how many questions the participant was asked so far.
        answers: how many he answered; the others were skipped.
        true_names: of the objects by perceived id, of each set as it was seen.
        left: the source objects as the demonstration left them.
    """

    def __init__(
        self,
        name: str,
        script: ParticipantScript,
        seed: int,
        settings: Settings,
        tape: Tape,
        *,
        answering: Answering | None = None,
    ) -> None:
        self.tape = tape
        self.cell_session = InProcessSession(script.scenes, seed, settings.perception, tape, settings.grasp)
        self._session = self.cell_session
        self._rng = np.random.default_rng([seed, THINKING_STREAM])
        self._source: Scene | None = None
        self._answering = answering or Answering(script)
        self.asked = self.answers = 0
        self.true_names: dict[Role, Mapping[str, str]] = {}
        self.left: Mapping[str, ObjectState] = {}
        self.loop = DialogueLoop(
            name,
            self._do,
            lambda: self._session.now,
            tape,
            MappingSettings(settings.mapping, settings.threshold),
            config=settings.dialogue,
        )

    def run(self) -> Phase:
        """The complete session; returns the phase it ended in, DONE unless the dialogue was aborted.

        Raises:
            SessionEndedError: a phase that does not come to its end.
            MbdError: the cell, perception or demonstration cannot do what it should.
        """
        self.prepare()
        self.next_phase()
        return self._phase

    def prepare(self) -> None:
        """Everything up to the robot's own work: both sets seen, the task shown, every question answered.

        Raises:
            SessionEndedError: a phase that does not come to its end.
            MbdError: the cell, perception or demonstration cannot do what it should.
        """
        self._lay(Phase.OBSERVE_SOURCE)
        self.next_phase()
        self._demonstrate()
        self.left = object_states(self._session.cell.simulation)
        self._lay(Phase.TUCK_AND_CLEAR)
        self.next_phase()
        self._enter(Phase.OBSERVE_TARGET)
        self.next_phase()
        while self._phase is Phase.ASSIST:
            self.answer()

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return self._session.seconds

    @property
    def _phase(self) -> Phase:
        return self.loop.dialogue.phase

    @property
    def _now(self) -> int:
        return self._session.now

    def _enter(self, phase: Phase) -> None:
        if self._phase is not phase:
            raise SessionEndedError(f"the session stays in {self._phase.name} instead of {phase.name}: {self._detail}")
        self._session.stage.enter(phase)

    @property
    def _detail(self) -> str:
        return self.loop.dialogue.detail

    def _lay(self, phase: Phase) -> None:
        """Wait until the experimenter has laid the table."""
        self._enter(phase)
        self._session.until(Word.READY)
        self._session.stage.acknowledge(Word.READY)

    def next_phase(self) -> None:
        """The operator leads on; raises SessionEndedError when the session cannot go on."""
        self.tape.write("wizard/command", Signal.NEXT_PHASE, self._now)
        reply = self.loop.feed(Event(Signal.NEXT_PHASE, self._now, "wizard/command"))
        if reply is None or not reply.accepted:
            raise SessionEndedError(f"the session cannot leave {self._phase.name}: {reply.reason if reply else ''}")

    def _demonstrate(self) -> None:
        self._enter(Phase.DEMONSTRATE)
        while self._phase is Phase.DEMONSTRATE:
            word = self._session.until(*ANSWERED_BY_GRIPPER, Word.DEMONSTRATION_BEGINS, Word.DEMONSTRATION_ENDS)
            if word in ANSWERED_BY_GRIPPER:
                self._grip(word)
                continue
            begins = word is Word.DEMONSTRATION_BEGINS
            signal = Signal.START if begins else Signal.STOP
            self.tape.write("wizard/demonstration", signal, self._now)
            reply = self.loop.feed(Event(signal, self._now, "wizard/demonstration"))
            if reply is None or not reply.accepted:
                raise SessionEndedError(f"the demonstration failed: {reply.reason if reply else 'no reply'}")
            if begins:
                self._session.stage.begin()

    def _grip(self, word: Word) -> None:
        self.tape.write("wizard/gripper", ANSWERED_BY_GRIPPER[word], self._now)
        self.loop.feed(Gripped(Signal.GRIPPER, self._now, "wizard/gripper", word is Word.CLOSE))
        self._session.grip(word)

    def answer(self) -> None:
        """The participant thinks, and answers the question asked; the operator skips it when there is no answer.

        Raises:
            SessionEndedError: nothing is asked, or the robot asks on and on.
        """
        self._session.pass_time(float(self._rng.uniform(*THINKING)))
        dialogue = self.loop.dialogue
        if self.asked >= MAX_QUESTIONS:
            raise SessionEndedError(f"the robot asks on after {MAX_QUESTIONS} questions: {dialogue.detail}")
        if dialogue.step_index < 0:
            raise SessionEndedError(f"the robot asks nothing and does not go on either: {dialogue.detail}")
        self.asked += 1
        yes_or_no = self._answering.yes_or_no(dialogue)
        if yes_or_no is not None:
            self.answers += 1
            self.tape.write("wizard/answer", yes_or_no, self._now)
            self.loop.feed(Event(yes_or_no, self._now, "wizard/answer"))
            return
        for target in self._answering.answers(dialogue):
            signal = self._answering.signal(dialogue)
            self.tape.write(f"wizard/{signal}", target, self._now)
            reply = self.loop.feed(Answered(signal, self._now, f"wizard/{signal}", target))
            if reply is not None and reply.accepted:
                self.answers += 1
                return
            self._session.pass_time(1.0)
        self.tape.write("wizard/command", Signal.SKIP, self._now)
        self.loop.feed(Event(Signal.SKIP, self._now, "wizard/command"))

    def _do(self, request: Request) -> Result:
        """A request of the dialogue, as the nodes do it."""
        try:
            if request in (Request.OBSERVE_SOURCE, Request.OBSERVE_TARGET):
                return self._observe(Role.SOURCE if request is Request.OBSERVE_SOURCE else Role.TARGET)
            if request is Request.START and self._source is not None:
                self._session.start_recording(self._source)
                return Result(True, f"recording over a source scene of {len(self._source.objects)} objects")
            if request is Request.STOP:
                task = self._session.stop_recording()
                if not task.steps:
                    return Result(False, "no step was demonstrated: " + "; ".join(task.problems))
                self.tape.write("demonstration/task", task, self._now)
                received = TaskReceived(Signal.TASK, self._now, task=task, stamp=to_nanoseconds(task.stamp))
                return Result(True, f"{len(task.steps)} steps recorded", facts=(received,))
        except MbdError as error:
            return Result(False, str(error))
        return Result(False, f"cannot {request} now")

    def _observe(self, role: Role) -> Result:
        seen = self._session.observe(role)
        self.true_names[role] = self._session.true_names(seen.scene)
        self._answering.see(role, self.true_names[role])
        if role is Role.SOURCE:
            self._source = seen.scene
        return Result(True, seen.summary, seen.scene if role is Role.TARGET else None)
