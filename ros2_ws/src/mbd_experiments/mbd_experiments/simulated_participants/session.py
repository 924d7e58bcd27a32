"""A simulated participant's session, in process: rendered RGB-D to assists, by the algorithms of every package.

The dialogue leads the session of the cell, asks, and the participant answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word
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
        self._tape = tape
        self._session = InProcessSession(script.scenes, seed, settings.perception, tape)
        self._rng = np.random.default_rng([seed, THINKING_STREAM])
        self._source: Scene | None = None
        self._answering = Answering(script)
        self._loop = DialogueLoop(
            name, self._do, lambda: self._session.now, tape, MappingSettings(settings.mapping, settings.threshold)
        )

    def run(self) -> Phase:
        """The complete session; returns the phase it ended in, DONE unless the dialogue was aborted.

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
            self._session.pass_time(float(self._rng.uniform(*THINKING)))
            self._answer()
        self._command()
        return self._phase

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return self._session.seconds

    @property
    def _phase(self) -> Phase:
        return self._loop.dialogue.phase

    @property
    def _now(self) -> int:
        return self._session.now

    def _enter(self, phase: Phase) -> None:
        if self._phase is not phase:
            raise SessionEndedError(f"the session stays in {self._phase.name} instead of {phase.name}: {self._detail}")
        self._session.stage.enter(phase)

    @property
    def _detail(self) -> str:
        return self._loop.dialogue.detail

    def _lay(self, phase: Phase) -> None:
        """Wait until the experimenter has laid the table."""
        self._enter(phase)
        self._session.until(Word.READY)
        self._session.stage.acknowledge(Word.READY)

    def _command(self) -> None:
        self._tape.write("wizard/command", Signal.NEXT_PHASE, self._now)
        reply = self._loop.feed(Event(Signal.NEXT_PHASE, self._now, "wizard/command"))
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
            self._tape.write("wizard/demonstration", signal, self._now)
            reply = self._loop.feed(Event(signal, self._now, "wizard/demonstration"))
            if reply is None or not reply.accepted:
                raise SessionEndedError(f"the demonstration failed: {reply.reason if reply else 'no reply'}")
            if begins:
                self._session.stage.begin()

    def _grip(self, word: Word) -> None:
        self._tape.write("wizard/gripper", ANSWERED_BY_GRIPPER[word], self._now)
        self._loop.feed(Gripped(Signal.GRIPPER, self._now, "wizard/gripper", word is Word.CLOSE))
        self._session.grip(word)

    def _answer(self) -> None:
        """The teacher answers the question asked; the operator skips it when there is no answer."""
        dialogue = self._loop.dialogue
        if dialogue.step_index < 0:
            raise SessionEndedError(f"the robot asks nothing and does not go on either: {dialogue.detail}")
        yes_or_no = self._answering.yes_or_no(dialogue)
        if yes_or_no is not None:
            self._tape.write("wizard/answer", yes_or_no, self._now)
            self._loop.feed(Event(yes_or_no, self._now, "wizard/answer"))
            return
        for target in self._answering.answers(dialogue):
            signal = self._answering.signal(dialogue)
            self._tape.write(f"wizard/{signal}", target, self._now)
            reply = self._loop.feed(Answered(signal, self._now, f"wizard/{signal}", target))
            if reply is not None and reply.accepted:
                return
            self._session.pass_time(1.0)
        self._tape.write("wizard/command", Signal.SKIP, self._now)
        self._loop.feed(Event(Signal.SKIP, self._now, "wizard/command"))

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
                self._tape.write("demonstration/task", task, self._now)
                received = TaskReceived(Signal.TASK, self._now, task=task, stamp=to_nanoseconds(task.stamp))
                return Result(True, f"{len(task.steps)} steps recorded", facts=(received,))
        except MbdError as error:
            return Result(False, str(error))
        return Result(False, f"cannot {request} now")

    def _observe(self, role: Role) -> Result:
        seen = self._session.observe(role)
        self._answering.see(role, self._session.true_names(seen.scene))
        if role is Role.SOURCE:
            self._source = seen.scene
        return Result(True, seen.summary, seen.scene if role is Role.TARGET else None)
