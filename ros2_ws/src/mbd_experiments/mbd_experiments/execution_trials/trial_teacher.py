"""The scripted teacher of a trial: answers from what he sees, puts right what was disturbed, and lies if he is to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from mbd_cell.adversary import Adversary
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import Signal
from mbd_model.objects import Role

from mbd_experiments.simulated_participants.answering import Answering
from mbd_experiments.simulated_participants.script import ParticipantScript

MAX_ANSWERS = 2  # about one step of the execution; then it is left out


class TrialTeacher(Answering):
    """A teacher.

    Args:
        script: what he shows and means.
        lies: his first answer is wrong.

    Attributes:
        adversary: whose doings he puts right when the robot asks; None before the robot is at work.
        mended: true names of the objects he put right.
        lied: whether he has lied.
    """

    def __init__(self, script: ParticipantScript, lies: bool) -> None:
        super().__init__(script)
        self._lies = lies
        self.adversary: Adversary | None = None
        self.mended: list[str] = []
        self.lied = False
        self._answered: Counter[int] = Counter()

    def yes_or_no(self, dialogue: Dialogue) -> Signal | None:
        """As he sees it; once the other way round."""
        said = super().yes_or_no(dialogue)
        if said in (Signal.YES, Signal.NO) and self._is_to_lie():
            return Signal.NO if said is Signal.YES else Signal.YES
        return said

    def answers(self, dialogue: Dialogue) -> Iterator[str]:
        """Right objects, that first which the robot has in mind; none after some answers about one step at work."""
        step = dialogue.steps[dialogue.step_index]
        if self.adversary is not None:
            self.mended += self.adversary.put_right(self._concerned(dialogue))
            self._answered[step.index] += 1
            if self._answered[step.index] > MAX_ANSWERS:
                return
        if not (dialogue.question and dialogue.question.target_ids) and self._is_to_lie():
            right = self._ids(step.primary_object)
            yield from (t for t in sorted(self._names[Role.TARGET]) if t not in right)
        last = dialogue.last_estimate
        had = last.estimate.executed.as_dict if last and last.estimate else {}
        yield from sorted(super().answers(dialogue), key=lambda target: target != had.get(step.primary_object))

    def _is_to_lie(self) -> bool:
        if self._lies and not self.lied:
            self.lied = True
            return True
        return False

    def _ids(self, source_id: str) -> list[str]:
        """Perceived ids of the right targets for a perceived source object."""
        right = self._script.preference.get(self._names[Role.SOURCE].get(source_id, ""), ())
        return [perceived for perceived, name in self._names[Role.TARGET].items() if name in right]

    def _concerned(self, dialogue: Dialogue) -> set[str]:
        """True names of the target objects that the step asked about, and its other half, may be about."""
        first = dialogue.step_index // 2 * 2
        steps = dialogue.steps[first : first + 2]
        sources = {self._names[Role.SOURCE].get(s.primary_object, "") for s in steps}
        return {name for source in sources for name in self._script.preference.get(source, ())}
