"""What a participant answers when the robot asks, from what he means and what perception calls it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import Signal
from mbd_interaction.phases.answers import SIGNAL_OF_STEP
from mbd_model.objects import Role
from mbd_model.session import PromptKind

from mbd_experiments.simulated_participants.script import ParticipantScript


class Answering:
    """A participant, as far as answers go.

    Args:
        script: what he means and prefers.

    Attributes:
        script: as given.
        names: true name by perceived id, of each set that was seen.
    """

    def __init__(self, script: ParticipantScript) -> None:
        self.script = script
        self.names: dict[Role, Mapping[str, str]] = {}
        self._repeated = not script.repeats

    def see(self, role: Role, names: Mapping[str, str]) -> None:
        """Perception saw this set: from now on he knows which id is which object (true name) on the table."""
        self.names[role] = names

    def signal(self, dialogue: Dialogue) -> Signal:
        """Whether he hands over or points."""
        return SIGNAL_OF_STEP[dialogue.steps[dialogue.step_index].kind]

    def yes_or_no(self, dialogue: Dialogue) -> Signal | None:
        """His answer to a question that names target objects: yes, no, or None where it takes an object."""
        question = dialogue.question
        if question is None or not question.target_ids:
            return None
        names = self.names.get(Role.TARGET, {})
        right = self.script.preference.get(self._meant(dialogue), ())
        fits = [target for target in question.target_ids if names.get(target) in right]
        if not fits:
            return Signal.NO
        return None if question.kind is PromptKind.WHICH_OF_TWO else Signal.YES

    def answers(self, dialogue: Dialogue) -> Iterator[str]:
        """Target ids in the order he tries them until one is accepted; first the last one again, if that is his slip.

        A right one that the question names comes first, then one that is free; when others' mix-ups took all of them,
        he gives a right one that is not.
        """
        named = dialogue.question.target_ids if dialogue.question else ()
        given = [a.target_id for a in dialogue.assists]
        if given and not named and not self._repeated:
            self._repeated = True
            yield given[-1]
        id_of = {name: perceived for perceived, name in self.names.get(Role.TARGET, {}).items()}
        right = [id_of[n] for n in self.script.preference.get(self._meant(dialogue), ()) if n in id_of]
        yield from sorted(right, key=lambda target: (bool(named) and target not in named, target in given))

    def _meant(self, dialogue: Dialogue) -> str:
        """True name of the source object he thinks the question is about."""
        # A demonstration of which steps were lost or added is no longer step by step what he remembers.
        if len(dialogue.steps) == len(self.script.meant):
            return self.script.meant[dialogue.step_index]
        return self.names.get(Role.SOURCE, {}).get(dialogue.steps[dialogue.step_index].primary_object, "")
