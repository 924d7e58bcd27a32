"""The upright box around the points of one object."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class UprightBox:
    """A box with vertical sides.

    Attributes:
        center: (x, y) [m, base frame].
        width, depth: extents along y and x at yaw 0 [m].
        yaw: rotation about z [rad], in (-pi/4, pi/4].
    """

    center: tuple[float, float]
    width: float
    depth: float
    yaw: float


# A round object has the same rectangle at every angle, and noise would choose one: the turned rectangle must be this
# much smaller than the straight one. A square turned by 3 degrees still counts as straight.
TURNED_AREA = 0.92


def upright_box(ground: NDArray[np.float32], trim: float = 0.002) -> UprightBox:
    """The smallest rectangle around points seen from above, straight unless turning it makes it clearly smaller.

    Args:
        ground: (n, 2) x, y [m, base frame], n >= 1.
        trim: share of the points left out at each end of each axis: stray pixels at silhouettes.
    """
    axes = np.ascontiguousarray(ground.T)
    places = [round(share * (len(ground) - 1)) for share in (trim, 1 - trim)]
    inner = np.ones(len(ground), dtype=bool)
    for values in axes:
        ends = np.partition(values, places)[places]
        inner &= (values >= ends[0]) & (values <= ends[1])
    if np.count_nonzero(inner) >= 3:
        axes = np.compress(inner, axes, axis=1)
    low, high = axes.min(axis=1), axes.max(axis=1)
    straight = float(np.prod(high - low))
    hull = cv2.convexHull(np.ascontiguousarray(axes.T, dtype=np.float32))
    middle, (side_x, side_y), angle = cv2.minAreaRect(hull)
    least = 1e-3  # a box has no zero side
    if straight <= 0 or side_x * side_y >= TURNED_AREA * straight:
        center = 0.5 * (low + high)
        return UprightBox(
            center=(float(center[0]), float(center[1])),
            width=max(float(high[1] - low[1]), least),
            depth=max(float(high[0] - low[0]), least),
            yaw=0.0,
        )
    yaw = math.radians(angle)
    while yaw > math.pi / 4:
        yaw, side_x, side_y = yaw - math.pi / 2, side_y, side_x
    while yaw <= -math.pi / 4:
        yaw, side_x, side_y = yaw + math.pi / 2, side_y, side_x
    return UprightBox(center=(middle[0], middle[1]), width=max(side_y, least), depth=max(side_x, least), yaw=yaw)
