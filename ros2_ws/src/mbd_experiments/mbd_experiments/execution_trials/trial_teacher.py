"""The scripted teacher of a trial: answers from what he sees, puts right what was disturbed, and lies if he is to."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping

from mbd_cell.adversary import Adversary
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_execution.plan import Transfer
from mbd_execution.work.failures import Trouble
from mbd_execution.work.state import Work
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import Signal
from mbd_model.execution_progress import Failure
from mbd_model.objects import Role
from mbd_model.session import PromptKind

from mbd_experiments.simulated_participants.answering import Answering
from mbd_experiments.simulated_participants.script import ParticipantScript

SET_ASIDE = frozenset({Failure.NOT_GRASPED, Failure.SLIPPED, Failure.WRONG_OBJECT, Failure.NO_WAY})
MAX_ANSWERS = 2  # about one step of the execution; then it is left out


class TrialTeacher(Answering):
    """A teacher.

    Args:
        script: what he shows and means.
        lies: his first answer is wrong.

    Attributes:
        adversary: whose doings he puts right when the robot asks; None before the robot is at work.
        work: gives where the robot is, which he sees.
        mended: true names of the objects he put right.
        lied: whether he has lied.
    """

    def __init__(self, script: ParticipantScript, lies: bool) -> None:
        super().__init__(script)
        self._lies = lies
        self.adversary: Adversary | None = None
        self.work: Callable[[], Work | None] = _nobody
        self.mended: list[str] = []
        self.lied = False
        self._answered: Counter[int] = Counter()

    def yes_or_no(self, dialogue: Dialogue) -> Signal | None:
        """As he sees it; once the other way round."""
        if dialogue.question is not None and dialogue.question.kind is PromptKind.PUT_IT_RIGHT:
            return self._help(dialogue)
        said = super().yes_or_no(dialogue)
        if said in (Signal.YES, Signal.NO) and self._is_to_lie():
            return Signal.NO if said is Signal.YES else Signal.YES
        return said

    def answers(self, dialogue: Dialogue) -> Iterator[str]:
        """Right objects, that first which the robot has in mind; none after some answers about one step at work."""
        step = dialogue.steps[dialogue.step_index]
        if dialogue.question is not None and dialogue.question.kind is PromptKind.PUT_IT_RIGHT:
            return  # he has had enough of it
        if self.adversary is not None:
            self.mended += self.adversary.put_right(self._concerned(dialogue))
            self._answered[step.index] += 1
            if self._answered[step.index] > MAX_ANSWERS:
                return
        if not (dialogue.question and dialogue.question.target_ids) and self._is_to_lie():
            right = self._ids(step.primary_object)
            yield from (t for t in sorted(self.names[Role.TARGET]) if t not in right)
        last = dialogue.last_estimate
        had = last.estimate.executed.as_dict if last and last.estimate else {}
        yield from sorted(super().answers(dialogue), key=lambda target: target != had.get(step.primary_object))

    def _help(self, dialogue: Dialogue) -> Signal | None:
        """Puts right what he is asked to, and says yes; to a question which of two it is, what is so.

        After some requests about one step he has it left out.
        """
        self._answered[dialogue.step_index] += 1
        if self.adversary is None or self._answered[dialogue.step_index] > MAX_ANSWERS:
            return None
        self.mended += self.adversary.put_right(self._concerned(dialogue))
        work = self.work()
        asked = work.failure if work else None
        if work is not None and asked is not None:
            self.mended += self._do_as_asked(work, asked)
        if work is not None and asked is not None and asked.otherwise is not None:
            return Signal.YES if self._off(work.table) <= self._off(asked.otherwise) else Signal.NO
        return Signal.YES

    def _do_as_asked(self, work: Work, asked: Trouble) -> tuple[str, ...]:
        """What the request of a failure says to do with the object: put it where it belongs, or within reach."""
        transfer = next((t for t in work.plan.transfers if asked.step in (t.shown.pick, t.shown.place)), None)
        if transfer is None or self.adversary is None:
            return ()
        held = self.names[Role.TARGET].get(transfer.held, "")
        if asked.failure is Failure.NOT_IN_PLACE and transfer.receiver:
            others = (d.transfer for d in work.done if d.transfer.held in asked.also)
            return tuple(name for t in (transfer, *others) for name in self._put_onto(t, self.adversary))
        if asked.failure in SET_ASIDE:
            return self.adversary.put_back(held)
        return ()

    def _put_onto(self, transfer: Transfer, adversary: Adversary) -> tuple[str, ...]:
        """What stood on something goes there again; what stood on the table stays where it is."""
        names, sources = self.names[Role.TARGET], self.names[Role.SOURCE]
        held, receiver = names.get(transfer.held, ""), names.get(transfer.receiver or "", "")
        if not receiver:
            return ()
        return adversary.put_onto(held, receiver, self._offset(sources, transfer.shown.picked.object_id, receiver))

    def _offset(self, sources: Mapping[str, str], picked: str, receiver: str) -> tuple[float, float]:
        """Where on the receiver (x, y) [m] he showed that object, in proportion to the receiver's size."""
        scenes, name = self.script.scenes, sources.get(picked, "")
        step = next((s for s in reversed(scenes.steps) if s.picked == name and s.onto is not None), None)
        if step is None:
            return 0.0, 0.0
        one = next(o.size for o in scenes.source if o.name == step.onto)
        other = next((o.size for o in scenes.target if o.name == receiver), one)
        return step.position[0] * other[0] / one[0], step.position[1] * other[1] / one[1]

    def _off(self, table: TrackedObjects) -> float:
        """How far off the true places [m] the objects are believed to be, in sum."""
        if self.adversary is None:
            return 0.0
        names = self.names[Role.TARGET]
        return sum(
            math.dist(o.centroid[:2], self.adversary.place_of(names[o.object_id]))
            for o in table.objects
            if o.object_id in names
        )

    def _is_to_lie(self) -> bool:
        if self._lies and not self.lied:
            self.lied = True
            return True
        return False

    def _ids(self, source_id: str) -> list[str]:
        """Perceived ids of the right targets for a perceived source object."""
        right = self.script.preference.get(self.names[Role.SOURCE].get(source_id, ""), ())
        return [perceived for perceived, name in self.names[Role.TARGET].items() if name in right]

    def _concerned(self, dialogue: Dialogue) -> set[str]:
        """True names of the target objects that the step asked about, and its other half, may be about."""
        first = dialogue.step_index // 2 * 2
        steps = dialogue.steps[first : first + 2]
        sources = {self.names[Role.SOURCE].get(s.primary_object, "") for s in steps}
        return {name for source in sources for name in self.script.preference.get(source, ())}


def _nobody() -> None:
    """No robot is at work."""
