"""One measure of a study, value by value, and what its design is: who met which condition, how often."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np
from mbd_model.errors import MbdError

# Whole numbers on at most so many levels are ratings or small counts: their order is sure, their distances are not.
FEW_LEVELS = 11


class AnalysisError(MbdError):
    """A table that cannot be analysed, or columns that are not in it."""


class MeasureScale(Enum):
    """What a measure's numbers mean, in the words of the tables."""

    YES_NO = "yes or no"
    LEVELS = "ratings or small counts"
    NUMBERS = "numbers"


class StudyDesign(Enum):
    """Whether conditions are compared within participants, or between them."""

    WITHIN = "within participants"
    BETWEEN = "between participants"


@dataclass(frozen=True)
class MeasuredValue:
    """One value: of whom, in which condition, in which block (a task, say; "" where there is none)."""

    participant: str
    condition: str
    value: float
    block: str = ""


@dataclass(frozen=True)
class MeasuredValues:
    """All values of one measure.

    Attributes:
        name: of the measure.
        scale: of its numbers.
        values: in any order.
    """

    name: str
    scale: MeasureScale
    values: tuple[MeasuredValue, ...]

    @cached_property
    def conditions(self) -> tuple[str, ...]:
        """In the order of their first value."""
        return tuple(dict.fromkeys(v.condition for v in self.values))

    @cached_property
    def participants(self) -> tuple[str, ...]:
        """In the order of their first value."""
        return tuple(dict.fromkeys(v.participant for v in self.values))

    @cached_property
    def blocks(self) -> tuple[str, ...]:
        """In the order of their first value."""
        return tuple(dict.fromkeys(v.block for v in self.values))

    @cached_property
    def counts(self) -> np.ndarray:
        """Number of values, (participants, conditions)."""
        return self._cells()[0]

    @cached_property
    def means(self) -> np.ndarray:
        """Each participant's mean in each condition, (participants, conditions); NaN where there is none."""
        counts, sums = self._cells()
        with np.errstate(invalid="ignore"):
            return np.where(counts > 0, sums / np.where(counts > 0, counts, 1), np.nan)

    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        counts = np.zeros((len(self.participants), len(self.conditions)), dtype=int)
        sums = np.zeros(counts.shape)
        rows = {name: k for k, name in enumerate(self.participants)}
        columns = {name: k for k, name in enumerate(self.conditions)}
        for one in self.values:
            cell = rows[one.participant], columns[one.condition]
            counts[cell] += 1
            sums[cell] += one.value
        return counts, sums

    @property
    def design(self) -> StudyDesign:
        """Within participants as soon as one of them met several conditions."""
        return StudyDesign.WITHIN if ((self.counts > 0).sum(axis=1) > 1).any() else StudyDesign.BETWEEN

    @property
    def complete(self) -> np.ndarray:
        """Whether a participant met every condition, (participants,)."""
        return np.asarray((self.counts > 0).all(axis=1))

    @property
    def repeated(self) -> bool:
        """Whether a participant has several values in one condition."""
        return bool((self.counts > 1).any())

    @property
    def balanced(self) -> bool:
        """Whether each participant that met a condition has equally many values in each block of it."""
        cells = [(v.participant, v.condition, v.block) for v in self.values]
        seen = {cell: cells.count(cell) for cell in set(cells)}
        met = int((self.counts > 0).sum())
        return len(set(seen.values())) == 1 and len(seen) == met * len(self.blocks)

    def group(self, condition: str) -> np.ndarray:
        """The participants' means in a condition, without those who did not meet it."""
        column = self.means[:, self.conditions.index(condition)]
        return np.asarray(column[~np.isnan(column)])

    def pairs(self, one: str, other: str) -> tuple[np.ndarray, np.ndarray]:
        """The means of those who met both conditions, in the same order."""
        first, second = (self.means[:, self.conditions.index(name)] for name in (one, other))
        both = ~(np.isnan(first) | np.isnan(second))
        return first[both], second[both]


def scale_of(values: Sequence[float], *, truths: bool = False) -> MeasureScale:
    """What numbers look like: truth values, few whole levels, or anything.

    Args:
        values: of a measure.
        truths: they stood as true and false in the table.
    """
    levels = set(values)
    if truths or levels <= {0.0, 1.0}:
        return MeasureScale.YES_NO
    if len(levels) <= FEW_LEVELS and all(float(v).is_integer() for v in levels):
        return MeasureScale.LEVELS
    return MeasureScale.NUMBERS
