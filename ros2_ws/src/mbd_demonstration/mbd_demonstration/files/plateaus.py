"""When a hand holds, read off a raw finger opening by brute force: an independent check of dated gripper events."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

NEAR = 0.02  # of the way between two levels


def held_levels(
    stamps: NDArray[np.float64], width: NDArray[np.float64], rough: Sequence[tuple[str, float]]
) -> list[tuple[str, float]]:
    """(type, time [s]) of each rough event moved to where the raw width arrives at its held level or leaves it.

    Args:
        stamps: (n,) increasing [s].
        width: (n,) as recorded, nothing filtered.
        rough: ("close" or "open", time [s]) in order, within the finger's motion.

    The held level is the commonest width between a closing and the opening after it; no code of the product is used.
    """
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
        found.append((kind, float(stamps[there[0] if kind == "close" else there[-1]])))
    return found


def commonest(values: NDArray[np.float64]) -> float:
    """The middle of the narrowest interval that holds half of the values."""
    ordered = np.sort(values)
    half = max(ordered.size // 2, 1)
    widths = ordered[half:] - ordered[:-half] if ordered.size > half else np.zeros(1)
    first = int(np.argmin(widths))
    return float(np.median(ordered[first : first + half + 1]))
