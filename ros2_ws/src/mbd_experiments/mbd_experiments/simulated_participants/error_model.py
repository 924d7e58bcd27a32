"""How participants go wrong, fitted to the paper's Table 5.

Of 10 participants a task, Table 5 counts those with a consistent demonstration, with consistent assists, and with both.
That fixes how many fall in each of the four cells (demonstration right or wrong, assists right or wrong): the model is
exactly that. Which participants they are, what they do wrong and where is drawn from the seed. Answers given twice
are drawn besides; their rate is that of the public half of the study's data (2 of 5 stacking sessions).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from mbd_model.errors import MbdError


class Slip(StrEnum):
    """What a participant does wrong."""

    WRONG_OBJECT = "wrong object"  # takes one object for another in the demonstration, and the other for the one
    MOVED_STACK = "moved stack"  # first moves what the others are to be placed onto
    PUT_ASIDE = "put aside"  # takes an object, puts it down elsewhere, takes it again
    WRONG_ORDER = "wrong order"  # hands over objects in another order than the demonstrated one
    REPEATED = "repeated"  # answers a question with the object of the answer before
    LATE = "late"  # his words to the hand are entered up to 1.5 s late; not in Table 5, and drawn by trials only


@dataclass(frozen=True)
class Consistency:
    """A row of Table 5.

    Attributes:
        demonstrations, assists, both: how many of ``of`` participants were consistent.
        of: participants.
    """

    demonstrations: int
    assists: int
    both: int
    of: int = 10

    @property
    def cells(self) -> dict[tuple[bool, bool], float]:
        """Share of participants by (demonstration consistent, assists consistent)."""
        counts = {
            (True, True): self.both,
            (True, False): self.demonstrations - self.both,
            (False, True): self.assists - self.both,
            (False, False): self.of - self.demonstrations - self.assists + self.both,
        }
        return {cell: count / self.of for cell, count in counts.items()}


TABLE5: Mapping[str, Consistency] = {
    "stacking": Consistency(6, 7, 4),
    "sorting": Consistency(6, 6, 5),
    "lunch_packing": Consistency(8, 10, 8),
}
DEMONSTRATION_SLIPS: Mapping[str, tuple[Slip, ...]] = {
    "stacking": (Slip.WRONG_OBJECT, Slip.MOVED_STACK),
    "sorting": (Slip.WRONG_OBJECT, Slip.MOVED_STACK),
    "lunch_packing": (Slip.PUT_ASIDE,),
}
REPEAT_RATE: Mapping[str, float] = {"stacking": 0.4, "sorting": 0.1, "lunch_packing": 0.1}


@dataclass(frozen=True)
class Intention:
    """What one participant is to get wrong in one task.

    Attributes:
        participant: "p1"...
        task: its name.
        seed: of everything else in the session: layout, guiding hand, camera noise, thinking times.
        slips: all of them; () for a faultless participant.
    """

    participant: str
    task: str
    seed: int
    slips: tuple[Slip, ...]

    @property
    def name(self) -> str:
        """Of the session and its bag."""
        return f"{self.participant}_{self.task}"

    @property
    def words(self) -> str:
        """For the bag's facts."""
        return ", ".join(self.slips) or "nothing wrong"


def intentions(participants: int, seed: int, tasks: tuple[str, ...] = tuple(TABLE5)) -> tuple[Intention, ...]:
    """The complete study, participant by participant.

    Args:
        participants: how many do every task.
        seed: of the study.
        tasks: of TABLE5.

    Raises:
        MbdError: no participant, or a task that Table 5 does not have.
    """
    if participants < 1:
        raise MbdError(f"a study of {participants} participants is none; give 1 or more")
    if unknown := sorted(set(tasks) - set(TABLE5)):
        raise MbdError(f"tasks {unknown} are not in the paper's study; expected some of {sorted(TABLE5)}")
    rows = []
    for task in tasks:
        rng = np.random.default_rng([seed, sorted(TABLE5).index(task)])
        cells = [cell for cell, count in quotas(TABLE5[task].cells, participants).items() for _ in range(count)]
        for number, place in enumerate(rng.permutation(len(cells)), start=1):
            slips = _slips(task, cells[int(place)], rng)
            rows.append((number, Intention(f"p{number}", task, int(rng.integers(1, 2**31 - 1)), slips)))
    return tuple(intention for _, intention in sorted(rows, key=lambda row: row[0]))


def quotas(shares: Mapping[tuple[bool, bool], float], total: int) -> dict[tuple[bool, bool], int]:
    """Integers in these shares that sum to ``total``; the largest remainders are rounded up."""
    exact = {cell: share * total for cell, share in shares.items()}
    counts = {cell: int(value + 1e-9) for cell, value in exact.items()}
    for cell in sorted(exact, key=lambda c: counts[c] - exact[c])[: total - sum(counts.values())]:
        counts[cell] += 1
    return counts


def _slips(task: str, cell: tuple[bool, bool], rng: np.random.Generator) -> tuple[Slip, ...]:
    shown_right, assisted_right = cell
    slips: list[Slip] = []
    if not shown_right:
        choices = DEMONSTRATION_SLIPS[task]
        slips.append(choices[int(rng.integers(len(choices)))])
    if not assisted_right:
        slips.append(Slip.WRONG_ORDER)
    if rng.random() < REPEAT_RATE[task]:
        slips.append(Slip.REPEATED)
    return tuple(slips)
