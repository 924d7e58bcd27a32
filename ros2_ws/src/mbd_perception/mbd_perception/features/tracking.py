"""Names that last: which object of this look at the table is which of the last one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.objects import SceneObject
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

# More than any sum of the terms below: never assigned, given the choice.
FORBIDDEN = 1e6


@dataclass(frozen=True)
class TrackingConfig:
    """When two objects can be the same.

    Attributes:
        max_move: how far one may have moved between looks [m].
        max_resize: by which factor its sides may have changed: another view of it, or noise.
        max_turn_of_hue: by how much its hue may differ [deg].
    """

    max_move: float = 0.05
    max_resize: float = 1.4
    max_turn_of_hue: float = 30.0


def dissimilarity(before: SceneObject, now: SceneObject, config: TrackingConfig) -> float:
    """0 for the same object in the same place, up to 3 for one that can still be the same, FORBIDDEN beyond."""
    move = float(np.hypot(before.centroid[0] - now.centroid[0], before.centroid[1] - now.centroid[1])) / config.max_move
    sides = np.array([[max(o.size[:2]), min(o.size[:2]), o.size[2]] for o in (before, now)])
    resize = float(np.abs(np.log(sides[0] / sides[1])).max() / np.log(config.max_resize))
    turn = 0.0
    if before.hue is not None and now.hue is not None:
        turn = abs((before.hue - now.hue + 180.0) % 360.0 - 180.0) / config.max_turn_of_hue
    return move + resize + turn if max(move, resize, turn) <= 1.0 else FORBIDDEN


def lasting_ids(
    known: Sequence[SceneObject], seen: Sequence[SceneObject], prefix: str, config: TrackingConfig
) -> tuple[str, ...]:
    """An id for each object seen: that of the known object it is, else the lowest free number.

    The pairing is the cheapest one overall (assignment problem, polynomial time), so objects that moved a little past
    each other are not swapped for want of looking at all of them.

    Args:
        known: objects of the last look.
        seen: objects of this look, in the order in which new numbers are given.
        prefix: of a new id, before its number.
        config: when two can be the same.
    """
    ids = [""] * len(seen)
    if known and seen:
        cost: NDArray[np.float64] = np.array([[dissimilarity(b, n, config) for n in seen] for b in known])
        rows, columns = linear_sum_assignment(cost)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            if cost[row, column] < FORBIDDEN:
                ids[column] = known[row].object_id
    taken = set(ids)
    free = (f"{prefix}{n}" for n in range(1, len(known) + len(seen) + 1))
    fresh = (name for name in free if name not in taken)
    return tuple(name or next(fresh) for name in ids)
