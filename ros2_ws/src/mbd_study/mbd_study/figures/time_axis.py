"""A time axis that stays readable: moments keep apart, waits are cut short and marked, and it goes on in rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SCALE = 9.0  # [px/s]
APART = 13.0  # least distance of two moments [px]
_CLOSEST = 10.5  # where the last row is saved [px]
_SPARE = 0.2  # of a row: less of it is no row of its own
LONGEST = 90.0  # of what is between two moments; a longer wait is cut to it [px]


@dataclass(frozen=True)
class TimePlace:
    """Where a moment is: number of the row from 0, and how far in it [px]."""

    row: int
    x: float


@dataclass(frozen=True)
class CutWait:
    """A wait that the axis shows shorter than it is: from ``start`` to ``end`` [s]."""

    start: float
    end: float


class TimeAxis:
    """Moments to places, by their number: equal times stand beside each other, in the order they are given in.

    Args:
        moments: times of all that is shown [s], in order.
        names: (number of a moment, length of the words [px]) of what is written from there on, as phases are.
        width: of a row [px].
    """

    def __init__(self, moments: Sequence[float], names: Sequence[tuple[int, float]], width: float) -> None:
        self.width = width
        self.times = sorted(moments)
        widths = [min(LONGEST, max(APART, SCALE * (b - a))) for a, b in zip(self.times, self.times[1:], strict=False)]
        starts = [number for number, _ in names]
        ends = [*starts[1:], len(self.times) - 1][: len(starts)]
        for (_, length), first, last in zip(names, starts, ends, strict=True):
            short = length - sum(widths[first:last])
            if last > first and short > 0:
                # A phase of a second gets room for its name.
                for k in range(first, last):
                    widths[k] += short / (last - first)
        short = sum(widths) % width
        if width < sum(widths) and 0 < short < _SPARE * width:
            # What little would be left for the last row fits into the others.
            share = (sum(widths) - short) / (1.03 * sum(widths))
            widths = [max(_CLOSEST, share * wide) for wide in widths]
        self._offsets = [0.0]
        for wide in widths:
            at = self._offsets[-1]
            # A step that does not fit into its row begins the next.
            if at % width + wide > width:
                at = (at // width + 1) * width
            self._offsets.append(at + wide)
        self._begins = [b - w for b, w in zip(self._offsets[1:], widths, strict=True)]
        self.cuts = tuple(
            CutWait(a, b)
            for a, b, w in zip(self.times, self.times[1:], widths, strict=False)
            if SCALE * (b - a) > LONGEST + 1 and w < SCALE * (b - a)
        )

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.place_of(len(self.times) - 1).row + 1

    def place_of(self, number: int) -> TimePlace:
        """The place of a moment by its number in ``times``."""
        # The end of a row is in it, not before the next.
        offset = self._offsets[number]
        row = max(0, int((offset - 1e-6) // self.width))
        return TimePlace(row, offset - row * self.width)

    def begin_of(self, number: int) -> TimePlace:
        """Where the way to the moment after ``number`` begins: in the next row, where it does not fit into this one."""
        if number >= len(self._begins):
            return self.place_of(number)
        row = int((self._begins[number] + 1e-6) // self.width)
        return TimePlace(row, self._begins[number] - row * self.width)

    def stretches(self, first: int, last: int) -> tuple[tuple[int, float, float], ...]:
        """The way from one moment to another, a piece for each row: (row, from, to) [px].

        Args:
            first: number of the moment in ``times``.
            last: of the other one.
        """
        pieces: dict[int, tuple[float, float]] = {}
        for number in range(first, last):
            begin, end = self.begin_of(number), self.place_of(number + 1)
            low, _ = pieces.get(begin.row, (begin.x, end.x))
            pieces[begin.row] = (low, end.x)
        return tuple((row, low, high) for row, (low, high) in sorted(pieces.items()))
