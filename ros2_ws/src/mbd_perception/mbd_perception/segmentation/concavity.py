"""Where a surface bends away from the viewer: the creases at which one object ends and the next begins.

The depth of a convex solid along a ray is the largest of the depths of its faces' planes, each of which is linear in
inverse depth w: so w is a concave function of the pixel on a convex solid, and bends the other way only where two
solids meet (or in a hollow). This is the local-convexity criterion of Stein et al. 2014 (LCCP) without normals: the
second difference of w.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage

DIRECTIONS = ((0, 1), (1, 0), (1, 1), (1, -1))


def inverse_depth(depth: FloatImage) -> FloatImage:
    """W = 1/z [1/m], (height, width) float32; 0 where there is no depth."""
    return np.divide(np.float32(1), depth, out=np.zeros_like(depth), where=depth > 0)


def smoothed(w: FloatImage) -> FloatImage:
    """Inverse depth with its noise smoothed and its steps kept: a median twice, the value itself beside a hole."""
    smooth: FloatImage = cv2.medianBlur(cv2.medianBlur(w, 5), 5)
    return np.where((smooth == 0) | (w == 0), w, smooth)


def concavity(w: FloatImage, surfaces: NDArray[np.integer], focal: float, reach: int) -> FloatImage:
    """How sharply each surface bends towards the viewer: the change of slope (tan of the incidence) within ``reach``.

    Two faces that meet in a hollow edge at angles i1 and i2 to the line of sight give tan(i1) + tan(i2); noise of
    inverse depth s gives about 2.4 s focal / (w reach). Only pixels of one surface are compared, in four directions.

    Args:
        w: (height, width) float32 inverse depth [1/m], smoothed.
        surfaces: (height, width) labels, 0 = none.
        focal: focal length [px] of this picture.
        reach: distance compared over [px].

    Returns:
        (height, width) float32, 0 where convex.
    """
    bend = np.zeros_like(w)
    height, width = w.shape
    for dv, du in DIRECTIONS:
        step = reach if dv * du == 0 else max(1, round(reach / np.sqrt(2)))
        length = step if dv * du == 0 else step * np.sqrt(2)
        v, u = dv * step, abs(du) * step
        if height <= 2 * v or width <= 2 * u:
            continue
        mid = (slice(v, height - v), slice(u, width - u))
        ahead = (slice(2 * v, None), slice(2 * u, None) if du >= 0 else slice(None, width - 2 * u))
        behind = (slice(None, height - 2 * v), slice(None, width - 2 * u) if du >= 0 else slice(2 * u, None))
        second = w[ahead] + w[behind]
        second -= 2 * w[mid]
        second *= np.float32(focal / length)
        same = (surfaces[ahead] == surfaces[mid]) & (surfaces[behind] == surfaces[mid])
        second *= same
        np.maximum(bend[mid], second, out=bend[mid])
    bend /= np.maximum(w, np.float32(0.05))
    bend *= surfaces > 0
    return bend
