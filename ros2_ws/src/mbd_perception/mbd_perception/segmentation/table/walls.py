"""Walls: large upright planes that end the table. What lies in one or behind it stands on no table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.segmentation.components import renumbered
from mbd_perception.segmentation.table.plane import Plane, PlaneCandidate
from mbd_perception.segmentation.table.plane_search import STRIDE, inverse_error

# A wall is at least as large as that [m^2]: the largest face of a box of cereals has 0.06.
SMALLEST = 0.15
# It is upright within 12 degrees.
UPRIGHT = 0.2
# Less than this share of what is seen of the table lies behind it: a few stray pixels.
BEHIND = 0.02
# So far below the lower edge of a surface its surroundings are looked at [px], beyond mixed pixels.
REACH = 4


def walls_behind(
    found: Sequence[PlaneCandidate], table: Plane, depth: FloatImage, camera: Intrinsics, noise: float
) -> tuple[Plane, ...]:
    """Those of the planes found that are walls for this table.

    Args:
        found: the planes of the depth image, level or not.
        table: the one objects stand on.
        depth: (height, width) float32 [m], 0 = none.
        camera: its camera.
        noise: std of inverse depth [1/m].
    """
    upright = [c for c in found if c.patch >= SMALLEST and abs(float(c.plane.normal @ table.normal)) < UPRIGHT]
    if not upright:
        return ()
    on_table = (np.abs(inverse_error(depth, camera, table)) < 3 * noise) & (depth[::STRIDE, ::STRIDE] > 0)
    total = max(int(on_table.sum()), 1)
    walls = []
    for candidate in upright:
        beyond = inverse_error(depth, camera, candidate.plane) < -6 * noise
        if int((beyond & on_table).sum()) < BEHIND * total:
            walls.append(candidate.plane)
    return tuple(walls)


def before_walls(depth: FloatImage, camera: Intrinsics, walls: Sequence[Plane], noise: float) -> NDArray[np.bool_]:
    """(height, width) bool; pixels nearer than every wall by more than 4 ``noise`` of inverse depth [1/m]."""
    x, y = camera.rays()
    inverse = np.divide(1, depth, out=np.zeros_like(depth), where=depth > 0)
    before = np.ones(depth.shape, dtype=bool)
    for wall in walls:
        a, b, c = (np.float32(-v / wall.offset) for v in wall.normal)
        before &= inverse - (a * x + (b * y + c)) > np.float32(4 * noise)
    return before


def without_hanging(surfaces: NDArray[np.int32], wall: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Surfaces without those that hang on a wall: below most of their lower edge a wall is seen.

    Args:
        surfaces: (height, width) labels, 0 = none.
        wall: (height, width) bool; pixels that rise above the table but lie in a wall or behind it.
    """
    count = int(surfaces.max(initial=0))
    lower_edge = (surfaces[:-REACH] > 0) & (surfaces[1 : 1 - REACH or None] != surfaces[:-REACH])
    label = surfaces[:-REACH][lower_edge]
    under = wall[REACH:][lower_edge]
    edge = np.bincount(label, minlength=count + 1)
    hanging = np.bincount(label, weights=under, minlength=count + 1) > 0.5 * edge
    return renumbered(surfaces, np.where(hanging, 0, np.arange(count + 1)))
