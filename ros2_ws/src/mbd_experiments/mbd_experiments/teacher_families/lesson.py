"""One simulated session: two scenes, what the teacher has in mind, and the assists in the order they are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import UNMAPPED, Pair
from mbd_mapping.tables import Floats, ObjectTable

EQUAL = 1e-9


@dataclass(frozen=True)
class Lesson:
    """A session before anybody inferred anything.

    Attributes:
        source, target: n and m objects as the robot measures them.
        columns: (n,) what the teacher has in mind, UNMAPPED where there is no counterpart.
        score: (n, m) what the teacher goes by, for which ``columns`` is best; None when only ``columns`` will do.
        assists: what the teacher says, in order, one for each mapped object; errors included.
    """

    source: ObjectTable
    target: ObjectTable
    columns: tuple[int, ...]
    score: Floats | None
    assists: tuple[Pair, ...]

    def is_right(self, columns: Sequence[int]) -> bool:
        """Whether a mapping is the teacher's, or as good for what the teacher goes by."""
        if tuple(columns) == self.columns:
            return True
        if self.score is None or sum(c != UNMAPPED for c in columns) != sum(c != UNMAPPED for c in self.columns):
            return False
        return _total(self.score, columns) >= _total(self.score, self.columns) - EQUAL


def _total(score: Floats, columns: Sequence[int]) -> float:
    return float(sum(score[row, column] for row, column in enumerate(columns) if column != UNMAPPED))


def told_in_order(rng: np.random.Generator, columns: Sequence[int]) -> tuple[Pair, ...]:
    """Every correspondence, in random order."""
    rows = [row for row, column in enumerate(columns) if column != UNMAPPED]
    return tuple((int(row), int(columns[row])) for row in rng.permutation(rows))


@dataclass(frozen=True)
class Scenes:
    """Two scenes as they are and as the robot measures them; the same where measuring is exact.

    Attributes:
        source, target: as they are: what the teacher sees.
        seen_source, seen_target: as measured.
        truth: the true ones, compared.
    """

    source: ObjectTable
    target: ObjectTable
    seen_source: ObjectTable
    seen_target: ObjectTable
    truth: Comparison
