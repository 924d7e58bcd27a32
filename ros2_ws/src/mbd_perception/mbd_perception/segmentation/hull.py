"""Which points lie in a convex polygon."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


def inside_hull(
    points: Points, corners: Points, margin: Points | float = 0.0, seen_from: Points | None = None
) -> NDArray[np.bool_]:
    """Which points lie in a convex polygon.

    Args:
        points: (n, 2).
        corners: (k, 2) in cyclic order, either way round, k >= 3.
        margin: how far from every side a point must lie, one for all or (n,).
        seen_from: (2,) with it the margin counts at sides that face away from there, in proportion to how much.
    """
    following = np.roll(corners, -1, axis=0)
    along = following - corners
    area = np.sum(corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1])
    length = np.linalg.norm(along, axis=1)
    kept = length > 1e-9
    inward = np.sign(area) * np.stack([-along[kept, 1], along[kept, 0]], axis=1) / length[kept, None]
    counts = np.ones(len(inward))
    if seen_from is not None:
        sight = corners[kept] - seen_from
        away = -(inward * sight).sum(axis=1) / np.maximum(np.linalg.norm(sight, axis=1), 1e-9)
        counts = np.maximum(away, 0.0)
    # Sides by points: the sides are few. Single precision errs by less than a micrometre on a table.
    from_side = inward.astype(np.float32) @ points.T.astype(np.float32)
    from_side -= (inward * corners[kept]).sum(axis=1).astype(np.float32)[:, None]
    from_side -= np.multiply.outer(counts, np.asarray(margin)).astype(np.float32).reshape(len(inward), -1)
    within: NDArray[np.bool_] = from_side.min(axis=0) >= 0
    return within
