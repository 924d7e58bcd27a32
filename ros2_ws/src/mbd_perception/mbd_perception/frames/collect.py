"""Which frames belong to an observation: colour and depth of one moment, taken after it was asked for."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Generic, TypeVar

Color = TypeVar("Color")
Depth = TypeVar("Depth")
Item = TypeVar("Item")


# Of one moment beyond doubt [s]: half a period of a camera at 25 Hz. What is farther apart waits for a nearer one.
AT_ONCE = 0.02


class PairBuffer(Generic[Color, Depth]):
    """Pairs colour with depth of the same time; keeps at most ``size`` unpaired of each, so it never grows.

    Two that are more than ``AT_ONCE`` apart are a pair once a later image has come that is no nearer to either.

    Args:
        tolerance: largest difference of stamps within a pair [s].
        size: how many unpaired are kept of each kind.
    """

    def __init__(self, tolerance: float, size: int = 8) -> None:
        self._tolerance = tolerance
        self._size = size
        self._colors: OrderedDict[float, Color] = OrderedDict()
        self._depths: OrderedDict[float, Depth] = OrderedDict()

    @property
    def waiting(self) -> tuple[int, int]:
        """How many colour and depth images wait for their other half."""
        return len(self._colors), len(self._depths)

    def add_color(self, stamp: float, color: Color) -> tuple[Color, Depth] | None:
        """Take in a colour image; the pair that is known now, if any."""
        _keep(self._colors, stamp, color, self._size)
        return self._pair(stamp)

    def add_depth(self, stamp: float, depth: Depth) -> tuple[Color, Depth] | None:
        """Take in a depth image; the pair that is known now, if any."""
        _keep(self._depths, stamp, depth, self._size)
        return self._pair(stamp)

    def _pair(self, newest: float) -> tuple[Color, Depth] | None:
        """The two nearest in time, unless what comes next may be nearer; they and everything older are dropped."""
        near = min(
            (
                (abs(c - d), max(c, d), c, d)
                for c in self._colors
                for d in self._depths
                if abs(c - d) <= self._tolerance
            ),
            default=None,
        )
        if near is None:
            return None
        gap, later, at_color, at_depth = near
        if gap > AT_ONCE and newest <= later:
            return None
        return _take(self._colors, at_color), _take(self._depths, at_depth)


def _take(waiting: OrderedDict[float, Item], stamp: float) -> Item:
    """The item of that stamp; it and everything older are dropped."""
    item = waiting.pop(stamp)
    for old in [s for s in waiting if s <= stamp]:
        del waiting[old]
    return item


def _keep(waiting: OrderedDict[float, Item], stamp: float, item: Item, size: int) -> None:
    """Remember an item, forgetting the oldest beyond ``size``."""
    waiting[stamp] = item
    waiting.move_to_end(stamp)
    while len(waiting) > size:
        waiting.popitem(last=False)


# Clocks that differ by more than this are different clocks [s].
LARGEST_GAP = 10.0


def earliest_stamp(now: float, newest: float | None, largest_gap: float = LARGEST_GAP) -> float:
    """From which stamp on a frame counts as taken after a request [s].

    Frames are stamped by the camera's clock. Where that is the node's (real or simulated), it is the time of the
    request; where the two differ by more than ``largest_gap`` they are different clocks, and the newest frame seen
    must do.
    """
    if newest is None or abs(now - newest) <= largest_gap:
        return now
    return newest


@dataclass
class FrameCollector(Generic[Item]):
    """The frames of one observation, all of one kind: when the camera changes in between it begins again.

    Attributes:
        after: stamps must be later than this [s].
        wanted: how many frames.
        kind: what those that came have in common, such as their size; None before the first.
        frames: those that came, oldest first.
        refused: how many came that were too old.
    """

    after: float
    wanted: int
    kind: object = None
    frames: list[Item] = field(default_factory=list)
    refused: int = 0

    def offer(self, stamp: float, frame: Item, kind: object = None) -> bool:
        """Take the frame if it is late enough; True once complete. Those of another kind than its own are dropped."""
        if stamp < self.after - LARGEST_GAP:
            self.after = stamp  # the camera's clock was set back, or one stamp was none: what comes next is later
        if stamp <= self.after:
            self.refused += 1
            return len(self.frames) >= self.wanted
        if kind != self.kind and len(self.frames) < self.wanted:
            self.frames.clear()
            self.kind = kind
        if len(self.frames) < self.wanted:
            self.frames.append(frame)
        return len(self.frames) >= self.wanted
