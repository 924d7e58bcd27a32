"""Which frames belong to an observation: colour and depth of one moment, taken after it was asked for."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Generic, TypeVar

Color = TypeVar("Color")
Depth = TypeVar("Depth")
Item = TypeVar("Item")


class PairBuffer(Generic[Color, Depth]):
    """Pairs colour with depth of the same time; keeps at most ``size`` unpaired of each, so it never grows.

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
        """Take in a colour image; the pair it completes, if any."""
        other = _take(self._depths, stamp, self._tolerance)
        if other is not None:
            return color, other
        _keep(self._colors, stamp, color, self._size)
        return None

    def add_depth(self, stamp: float, depth: Depth) -> tuple[Color, Depth] | None:
        """Take in a depth image; the pair it completes, if any."""
        other = _take(self._colors, stamp, self._tolerance)
        if other is not None:
            return other, depth
        _keep(self._depths, stamp, depth, self._size)
        return None


def _take(waiting: OrderedDict[float, Item], stamp: float, tolerance: float) -> Item | None:
    """The waiting item nearest in time, within tolerance [s]; it and everything older are dropped."""
    near = min(waiting, key=lambda s: abs(s - stamp), default=None)
    if near is None or abs(near - stamp) > tolerance:
        return None
    item = waiting.pop(near)
    for old in [s for s in waiting if s <= near]:
        del waiting[old]
    return item


def _keep(waiting: OrderedDict[float, Item], stamp: float, item: Item, size: int) -> None:
    """Remember an item, forgetting the oldest beyond ``size``."""
    waiting[stamp] = item
    while len(waiting) > size:
        waiting.popitem(last=False)


def earliest_stamp(now: float, newest: float | None, largest_gap: float = 10.0) -> float:
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
    """The frames of one observation.

    Attributes:
        after: stamps must be later than this [s].
        wanted: how many frames.
        frames: those that came, oldest first.
        refused: how many came that were too old.
    """

    after: float
    wanted: int
    frames: list[Item] = field(default_factory=list)
    refused: int = 0

    def offer(self, stamp: float, frame: Item) -> bool:
        """Take the frame if it is late enough; True once complete."""
        if stamp <= self.after:
            self.refused += 1
        elif len(self.frames) < self.wanted:
            self.frames.append(frame)
        return len(self.frames) >= self.wanted
