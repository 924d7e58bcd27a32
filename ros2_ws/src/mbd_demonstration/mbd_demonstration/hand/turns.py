"""Where a signal turns: its crests and troughs, and the level at which it rests there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Of a turn: what of it still belongs to the level at its end, before the level itself is known.
NEAR_LEVEL = 0.1
# A level may creep by this share of its turn while the hand rests: soft things give way, joints drift.
CREEP = 0.05
# Fingers may go past the level at which they then stay, by this share of their way.
PAST = 0.35
# A level needs this many samples for its creep to be told from its noise.
FITTED = 12
# What goes slower than this share of its way a second no longer arrives, or does not yet leave: what is held gives way;
# below the second one it may [1/s]. Going on by more than the third is a motion of its own, however long it stopped.
GIVING, SLOW, AGAIN = 0.05, 0.15, 0.3


@dataclass(frozen=True)
class Turn:
    """An extreme of a signal.

    Attributes:
        index: of the sample.
        crest: True for a highest point, False for a lowest.
    """

    index: int
    crest: bool


def turns(values: Floats, size: float) -> tuple[Turn, ...]:
    """The extremes between which the signal goes at least ``size`` up or down, its first and last level included.

    Args:
        values: (n,).
        size: smallest way between two extremes, > 0.

    Returns:
        Crests and troughs in turn; none for a signal that never goes so far.
    """
    found: list[Turn] = []
    low = high = 0
    rising: bool | None = None
    for i, value in enumerate(values.tolist()):
        if value > values[high]:
            high = i
        if value < values[low]:
            low = i
        if rising is not True and value - values[low] >= size:
            found.append(Turn(low, crest=False))
            rising, high = True, i
        elif rising is not False and values[high] - value >= size:
            found.append(Turn(high, crest=True))
            rising, low = False, i
    if rising is not None:
        found.append(Turn(high, crest=True) if rising else Turn(low, crest=False))
    return tuple(found)


@dataclass(frozen=True)
class Crest:
    """A crest with the troughs beside it.

    Attributes:
        begin, peak, end: samples of the trough before, of the crest, of the trough after; the recording's ends where
            there is none.
        rises, falls: whether there is a trough before, and after.
    """

    begin: int
    peak: int
    end: int
    rises: bool
    falls: bool

    def ways(self, values: Floats) -> tuple[float, ...]:
        """Way from each of its troughs up to it, in the unit of ``values`` (n,)."""
        sides = [side for side, there in ((self.begin, self.rises), (self.end, self.falls)) if there]
        return tuple(float(values[self.peak] - values[side]) for side in sides)


def crests(extremes: Sequence[Turn], n: int) -> list[Crest]:
    """The crests among the extremes of a signal (n,)."""
    last = len(extremes) - 1
    return [
        Crest(
            extremes[k - 1].index if k else 0,
            turn.index,
            extremes[k + 1].index if k < last else n - 1,
            rises=k > 0,
            falls=k < last,
        )
        for k, turn in enumerate(extremes)
        if turn.crest
    ]


@dataclass(frozen=True)
class Rest:
    """The level of a crest.

    Attributes:
        first, last: the samples at which the signal stops to arrive at it and begins to leave it; what is held may
            give way between them, slowly.
        slow: the sample from which on it arrived so slowly that it may have been there.
        height: its mean height.
        lasts: [s] how long it rests there, less the time that it would be so near its extreme by turning alone.
    """

    first: int
    last: int
    slow: int
    height: float
    lasts: float


def rest_at(stamps: Floats, values: Floats, crest: Crest, *, settle: float, noise: float) -> Rest:
    """Where the signal rests around a crest.

    Args:
        stamps: (n,) [s].
        values: (n,).
        crest: the crest.
        settle: share of the turn within which it has arrived; at least three times the noise.
        noise: standard deviation of the values.
    """
    begin, peak, end = crest.begin, crest.peak, crest.end
    size = min(crest.ways(values), default=0.0)
    index = np.arange(begin, end + 1)
    slack = max(settle * size, 3.0 * noise)
    near = index[values[index] >= values[peak] - max(NEAR_LEVEL * size, 3.0 * noise)]
    upper = index[values[index] >= values[peak] - PAST * size]
    low, high = narrowest_half(values[upper])
    if high - low <= 2.0 * slack and high < values[near].min():
        near = upper[(values[upper] >= low - slack) & (values[upper] <= high + slack)]
    level = np.full(index.size, float(np.median(values[near])))
    if near.size >= FITTED:
        # The middle three fifths are neither arriving nor leaving; their two halves say how the level creeps.
        middle = near[near.size // 5 : near.size - near.size // 5]
        one, other = np.array_split(middle, 2)
        creep = float(np.median(values[other]) - np.median(values[one]))
        apart = float(np.median(stamps[other]) - np.median(stamps[one]))
        span = float(stamps[near[-1]] - stamps[near[0]])
        slope = float(np.clip(creep / apart * span, -CREEP * size, CREEP * size)) / span
        within = np.clip(stamps[index], stamps[near[0]], stamps[near[-1]])
        level = float(np.median(values[middle])) + slope * (within - float(np.median(stamps[middle])))
    there = index[values[index] >= level - slack]
    first, last = int(there[0]), int(there[-1])
    # What goes up and down at even speed is within the slack for that share of the time it is above half its way.
    above = index[values[index] >= values[peak] - 0.5 * size]
    turning = 2.0 * slack / size * float(stamps[above[-1]] - stamps[above[0]]) if size else 0.0
    lasts = float(stamps[last] - stamps[first]) - turning
    height = float(np.median(values[near]))
    below = np.maximum(height - values, 0.0)
    level_at = stamps[index[values[index] >= height - 0.25 * slack][[0, -1]]]
    ways = tuple(float(values[peak] - values[side]) for side in (begin, end))
    slow = first
    if ways[0] > 0.0:
        arriving = np.arange(first, begin - 1, -1)
        apart = np.abs(stamps[arriving] - level_at[0])
        first, slow = (int(arriving[_fast_until(apart, below[arriving] / ways[0], rate)]) for rate in (GIVING, SLOW))
    if ways[1] > 0.0:
        leaving = np.arange(last, end + 1)
        apart = np.abs(stamps[leaving] - level_at[1])
        last = int(leaving[_fast_until(apart, below[leaving] / ways[1], GIVING)])
    return Rest(first, last, slow, height, lasts)


def narrowest_half(values: Floats) -> tuple[float, float]:
    """(lowest, highest) of the narrowest interval that holds half of the values (n,), n >= 1."""
    ordered = np.sort(values)
    half = ordered.size // 2
    first = int(np.argmin(ordered[half:] - ordered[: ordered.size - half]))
    return float(ordered[first]), float(ordered[first + half])


def _fast_until(apart: Floats, below: Floats, rate: float) -> int:
    """Of the samples from the edge of a rest into the motion beside it, the one at which that motion is fast.

    Args:
        apart: (k,) [s] from the time at which the rest's level is reached, or left.
        below: (k,) how far below that level each is, as a share of the motion's way.
        rate: [1/s] below which it is slow.

    A second apart from the level is worth as much as going ``rate`` below it: that one is worth most.
    """
    worth = rate * apart - below
    worth[0] = 0.0
    worth[below > AGAIN] = -np.inf
    return int(np.argmax(worth))
