"""Whether what a driver states again and again stands still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Stated:
    """One statement of a driver.

    Attributes:
        number: how many there were; not its stamp, which some drivers leave at zero.
        values: whose standing still counts, all of one unit.
    """

    number: int
    values: tuple[float, ...]


class Standstill:
    """Looks at a driver's statements from the end of a motion on.

    An action may end before the driver has stated where: what was stated last is then a place on the way (Kinova's
    port states its joints ten times a second, and a hand closes in one). Only what is stated since counts, and it
    counts once two statements in turn say the same. How long that takes follows from the driver's rate.

    Args:
        known: the last statement when the motion ended, None where there is none.
        tolerance: two statements differ by at most so much where nothing moves, in their unit.
        most: a driver whose values tremble for so many statements is taken as it is.
    """

    def __init__(self, known: Stated | None, tolerance: float, most: int = 20) -> None:
        self._seen, self._tolerance, self._most = known, tolerance, most
        self.count = 0  # statements since

    def stands(self, now: Stated | None) -> bool:
        """Take what is stated now, which may be what was looked at before; whether it stands still."""
        before = self._seen
        if now is None or (before is not None and now.number <= before.number):
            return False
        self._seen = now
        self.count += 1
        if self.count >= self._most:
            return True
        return self.count > 1 and before is not None and _apart(before.values, now.values) <= self._tolerance


def _apart(a: Sequence[float], b: Sequence[float]) -> float:
    return max((abs(x - y) for x, y in zip(a, b, strict=True)), default=0.0)
