"""Which sessions of a plan are held when, with the operator's slips: in another order, or not to their end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from mbd_study.plan.schedule import PlannedSession

SLIP_STREAM = 21  # of chance, apart from those of sessions
FIRST = 1_788_253_200_000_000_000  # [ns] 2026-09-01 09:00 UTC: the first session's beginning; another every half hour
APART = 1_800_000_000_000  # [ns]


@dataclass(frozen=True)
class SlipRates:
    """How often things go wrong, each 0..1.

    Attributes:
        click: the operator presses another object, or another button, than he meant.
        noticed: of wrong objects pressed, how many he notices at once and undoes.
        order: he begins the participant's session after the next instead.
        ended: the participant wants to stop; of sessions.
    """

    click: float = 0.05
    noticed: float = 0.5
    order: float = 0.05
    ended: float = 0.03

    def __post_init__(self) -> None:
        """Validate once; raises MbdError for a share that is none."""
        for name, share in vars(self).items():
            if not 0.0 <= share <= 1.0:
                raise MbdError(f"the rate {name} is {share:g}; expected a share in 0..1, as 0.05")


@dataclass(frozen=True)
class HeldPlan:
    """One session as it is held.

    Attributes:
        planned: the session.
        begun: when, by the wall clock of the simulated lab [ns].
        deviation: where it leaves the plan, and why; "" where it does not.
        instead_of: the session that was next, when that was another.
        ended_early: the participant stops amid the questions.
    """

    planned: PlannedSession
    begun: int
    deviation: str = ""
    instead_of: str = ""
    ended_early: bool = False


def held_plan(planned: Sequence[PlannedSession], rates: SlipRates, seed: int) -> tuple[HeldPlan, ...]:
    """The sessions in the order they are held; the same for the same seed.

    Args:
        planned: by the plan.
        rates: of the operator's and participants' slips.
        seed: of the rehearsal.
    """
    rng = np.random.default_rng([seed, SLIP_STREAM])
    left = list(planned)
    held: list[HeldPlan] = []
    while left:
        after = left[1] if len(left) > 1 and left[1].participant == left[0].participant else None
        swapped = rng.random() < rates.order
        ended = bool(rng.random() < rates.ended)
        begun = FIRST + APART * len(held)
        if swapped and after is not None:
            why = f"held when {left[0].session} was next: the operator had laid the table for it"
            held.append(HeldPlan(after, begun, why, left[0].session, ended))
            del left[1]
        else:
            held.append(HeldPlan(left.pop(0), begun, ended_early=ended))
    return tuple(held)
