"""Which of the errors that are switched on a teacher makes in one session, at the rates of the paper's Table 5."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbd_experiments.simulated_participants.error_model import (
    DEMONSTRATION_SLIPS,
    REPEAT_RATE,
    TABLE5,
    Consistency,
    Intention,
    Slip,
)

ERROR_STREAM = 33  # of chance
LATE_RATE = 0.3  # an assumption: the study did not count late words
# Tasks that the paper's study did not have: as in its three together.
POOLED = Consistency(
    sum(row.demonstrations for row in TABLE5.values()),
    sum(row.assists for row in TABLE5.values()),
    sum(row.both for row in TABLE5.values()),
    sum(row.of for row in TABLE5.values()),
)
# Bowls are wider than the teacher's hand is led around: of dishes nothing that others go into is moved first.
OWN_SLIPS: Mapping[str, tuple[Slip, ...]] = {
    "assembly": (Slip.WRONG_OBJECT, Slip.MOVED_STACK),
    "dish_sorting": (Slip.WRONG_OBJECT, Slip.PUT_ASIDE),
}


def error_name(slip: Slip) -> str:
    """What a command calls it."""
    return slip.value.replace(" ", "_")


ERRORS = {error_name(slip): slip for slip in Slip}


def drawn_errors(task: str, seed: int, switched_on: Sequence[Slip]) -> Intention:
    """What the teacher of that session gets wrong: nothing that is not switched on.

    Args:
        task: its name.
        seed: of the session.
        switched_on: errors that may happen.
    """
    rng = np.random.default_rng([seed, ERROR_STREAM])
    shares = TABLE5.get(task, POOLED).cells
    shown_right, assisted_right = list(shares)[int(rng.choice(len(shares), p=list(shares.values())))]
    kinds = [s for s in DEMONSTRATION_SLIPS.get(task, OWN_SLIPS.get(task, ())) if s in switched_on]
    slips = []
    if not shown_right and kinds:
        slips.append(kinds[int(rng.integers(len(kinds)))])
    if not assisted_right and Slip.WRONG_ORDER in switched_on:
        slips.append(Slip.WRONG_ORDER)
    if Slip.REPEATED in switched_on and rng.random() < REPEAT_RATE.get(task, 0.1):
        slips.append(Slip.REPEATED)
    if Slip.LATE in switched_on and rng.random() < LATE_RATE:
        slips.append(Slip.LATE)
    return Intention("teacher", task, seed, tuple(slips))
