"""Rows of numbers that grow while a demonstration is recorded, 8 bytes a number; looks read few of them."""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

# A look while recording needs no more samples a second than this; the fingers and the hand show nothing faster then.
LOOK_RATE = 25.0


class Samples:
    """A growing table of ``width`` numbers a row, in order of arrival; the first is the stamp [s].

    Attributes:
        width: numbers in a row.
    """

    def __init__(self, width: int) -> None:
        self.width = width
        self._all = array("d")
        self._thin = array("d")
        self._last = -np.inf

    def __len__(self) -> int:
        """Rows."""
        return len(self._all) // self.width

    def add(self, *row: float) -> None:
        """One more row."""
        self._all.extend(row)
        stamp = row[0]
        # Also what is stamped before the last one is kept: its clock may have been set back.
        if not abs(stamp - self._last) < 1.0 / LOOK_RATE:
            self._thin.extend(row)
            self._last = stamp

    def table(self, *, thin: bool = False, since: int = 0) -> NDArray[np.float64]:
        """The rows (n, width) from row ``since`` on; ``thin``: at most LOOK_RATE a second of them."""
        numbers = self._thin if thin else self._all
        return np.array(numbers[since * self.width :], dtype=float).reshape(-1, self.width)

    def extend(self, rows: NDArray[np.float64]) -> None:
        """Many rows (n, width)."""
        for row in rows.tolist():
            self.add(*row)
