"""The operator's hand: it passes on what the participant answers, and now and then presses beside it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mbd_interaction.dialogue import Dialogue

from mbd_experiments.rehearsal.holding import SlipRates
from mbd_experiments.simulated_participants.answering import Answering
from mbd_experiments.simulated_participants.script import ParticipantScript


class ClickedAnswers(Answering):
    """A participant's answers as the operator clicks them.

    Args:
        script: what the participant means.
        rates: of the slips.
        rng: of their chance.

    Attributes:
        misclicked: the last answer was another object than the participant gave, and the operator saw that.
        wrong: how many answers were another object, noticed or not.
    """

    def __init__(self, script: ParticipantScript, rates: SlipRates, rng: np.random.Generator) -> None:
        super().__init__(script)
        self._rates, self._rng = rates, rng
        self.misclicked = False
        self.wrong = 0

    def answers(self, dialogue: Dialogue) -> Iterator[str]:
        """Target ids in the order they are pressed; a wrong one first when the operator slips."""
        self.misclicked = False
        meant = list(super().answers(dialogue))
        given = {a.target_id for a in dialogue.assists}
        others = [o for o in (dialogue.target.ids if dialogue.target else ()) if o not in meant and o not in given]
        if others and meant and self._rng.random() < self._rates.click:
            self.wrong += 1
            self.misclicked = bool(self._rng.random() < self._rates.noticed)
            yield others[int(self._rng.integers(len(others)))]
        yield from meant
