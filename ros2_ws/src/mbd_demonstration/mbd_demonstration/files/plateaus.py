"""When a hand holds, read off a raw finger opening by brute force: an independent check of dated gripper events.

No code of the reader is used. Where what is held gives way for a while, no one moment is right: then the check is the
stretch from the end of the fast motion to the arrival at the commonest level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

Floats = NDArray[np.float64]

NEAR = 0.02  # of the way between two levels
PROMINENT = 0.25  # of the range: what comes back by less is no act
# From this speed on [way/s], over so long [s], fingers move fast; a slow part longer than the last [s] is giving way.
FAST, OVER, GIVES = 0.15, 0.5, 0.5


@dataclass(frozen=True)
class HeldStretch:
    """When an event may be dated.

    Attributes:
        kind: "close" or "open".
        earliest, latest: [s]; the same where the width arrives at its level, or leaves it, without giving way.
    """

    kind: str
    earliest: float
    latest: float

    def off(self, stamp: float) -> float:
        """How far a time is outside [s]."""
        return max(self.earliest - stamp, stamp - self.latest, 0.0)


def acts(stamps: Floats, width: Floats) -> list[tuple[str, float]]:
    """("close" or "open", time [s] within the motion, near the closed hand) of each, in order.

    Args:
        stamps: (n,) increasing [s].
        width: (n,) as recorded, larger is more open.

    A recording begins closed where its hand is in the lower half of the range; else opening wider is no act.
    """
    span = float(np.ptp(width)) if width.size else 0.0
    if span <= 0.0:
        return []
    ends = np.array([width.max() + span])
    closed, _ = find_peaks(-np.concatenate([ends, width, ends]), prominence=PROMINENT * span)
    begins_open = width[0] > 0.5 * (width.min() + width.max())
    found: list[tuple[str, float]] = []
    for k, peak in enumerate(closed - 1):
        before = closed[k - 1] - 1 if k else 0
        after = closed[k + 1] - 1 if k + 1 < closed.size else width.size - 1
        for kind, (first, last) in (("close", (before, peak)), ("open", (peak, after))):
            side = width[first : last + 1]
            wide = first + int(np.argmax(side))
            if width[wide] - width[peak] < PROMINENT * span:
                continue
            if kind == "open" and k == 0 and begins_open and not found:
                continue
            way = np.arange(min(wide, peak), max(wide, peak) + 1)
            below = way[width[way] <= width[peak] + PROMINENT * span]
            found.append((kind, float(stamps[below[0] if kind == "close" else below[-1]])))
    return found


def held_levels(stamps: Floats, width: Floats, rough: Sequence[tuple[str, float]]) -> list[tuple[str, float]]:
    """(type, time [s]) of each rough event moved to where the raw width arrives at its held level or leaves it.

    Args:
        stamps: (n,) increasing [s].
        width: (n,) as recorded, nothing filtered.
        rough: ("close" or "open", time [s]) in order, within the finger's motion.

    The held level is the commonest width between a closing and the opening after it.
    """
    return [(kind, at) for kind, at, _ in _held(stamps, width, rough)]


def held_stretches(stamps: Floats, width: Floats, rough: Sequence[tuple[str, float]]) -> list[HeldStretch]:
    """Each rough event with the stretch in which it may be dated; arguments as of ``held_levels``."""
    found = []
    edges = [float(stamps[0]), *(at for _, at in rough), float(stamps[-1])]
    for k, (kind, held, way) in enumerate(_held(stamps, width, rough)):
        hold = (edges[k + 1], edges[k + 2]) if kind == "close" else (edges[k], edges[k + 1])
        fast = _fast_until(stamps, width / way, rough[k][1], hold, later=kind == "close") if way > 0.0 else held
        ends = (fast, held) if abs(fast - held) > GIVES else (held, held)
        found.append(HeldStretch(kind, min(ends), max(ends)))
    return found


def _held(stamps: Floats, width: Floats, rough: Sequence[tuple[str, float]]) -> list[tuple[str, float, float]]:
    """(type, time at the level [s], way from the level to the widest) of each rough event."""
    found = []
    edges = [float(stamps[0]), *(at for _, at in rough), float(stamps[-1])]
    for k, (kind, _) in enumerate(rough):
        hold = (edges[k + 1], edges[k + 2]) if kind == "close" else (edges[k], edges[k + 1])
        free = (edges[k], edges[k + 1]) if kind == "close" else (edges[k + 1], edges[k + 2])
        inside = (stamps >= hold[0]) & (stamps <= hold[1])
        level = commonest(width[inside])
        # The widest the hand was on the other side of this event is where it came from or went to.
        way = float(width[(stamps >= free[0]) & (stamps <= free[1])].max()) - level
        there = np.flatnonzero(inside & (np.abs(width - level) <= NEAR * way))
        if not there.size:
            there = np.flatnonzero(inside)[[int(np.argmin(np.abs(width[inside] - level)))]]
        found.append((kind, float(stamps[there[0] if kind == "close" else there[-1]]), way))
    return found


def _fast_until(stamps: Floats, share: Floats, at: float, hold: tuple[float, float], *, later: bool) -> float:
    """Until when (``later``), or from when on, the fingers move fast around a time ``at`` [s] within their motion."""
    within = stamps[(stamps >= hold[0]) & (stamps <= hold[1])]
    for stamp in within if later else within[::-1]:
        ahead = stamp + OVER if later else stamp - OVER
        gone = abs(float(np.interp(ahead, stamps, share) - np.interp(stamp, stamps, share)))
        if gone < FAST * OVER:
            return float(stamp)
    return at


def commonest(values: Floats) -> float:
    """The middle of the narrowest interval that holds half of the values."""
    ordered = np.sort(values)
    half = max(ordered.size // 2, 1)
    widths = ordered[half:] - ordered[:-half] if ordered.size > half else np.zeros(1)
    first = int(np.argmin(widths))
    return float(np.median(ordered[first : first + half + 1]))
