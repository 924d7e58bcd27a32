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
    result = np.ones(len(points), dtype=bool)
    for corner, normal in zip(corners[kept], inward, strict=True):
        counts = 1.0
        if seen_from is not None:
            sight = corner - seen_from
            counts = max(-float(normal @ sight) / max(float(np.linalg.norm(sight)), 1e-9), 0.0)
        result &= (points - corner) @ normal >= counts * np.asarray(margin)
    return result
