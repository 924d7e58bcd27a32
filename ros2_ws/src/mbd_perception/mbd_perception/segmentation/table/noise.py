"""How noisy the depth of this table is in this very frame."""

from __future__ import annotations

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics

from mbd_perception.frames.frame import FloatImage
from mbd_perception.quantile import median
from mbd_perception.segmentation.table.plane import Plane
from mbd_perception.segmentation.table.plane_search import STRIDE, inverse_error

# Of evenly spread errors the median is half of their range; of normal ones that fit into it, a ninth.
CUT_OFF = 0.55


def settled(depth: FloatImage, camera: Intrinsics, plane: Plane, expected: float) -> tuple[Plane, float]:
    """The table's plane and the std of inverse depth [1/m] on it.

    A table that the sensor bends is found by a part of it; its plane is then fitted again, to all that is seen of it.

    Args:
        depth: (height, width) float32 [m], 0 = none.
        camera: its camera.
        plane: the table as it was found.
        expected: std of inverse depth [1/m] with which it was found.
    """
    noise = measured_noise(depth, camera, plane, expected)
    if noise < 6 * CUT_OFF * expected:
        return plane, noise
    again = _refitted(depth, camera, plane, noise)
    return again, measured_noise(depth, camera, again, expected)


def measured_noise(depth: FloatImage, camera: Intrinsics, plane: Plane, expected: float) -> float:
    """Std of inverse depth [1/m] on this table, from the median error; 6 times ``expected`` off is no table.

    Where the errors fill that range, as on a table that the sensor bends, the range is doubled, and again.
    """
    sample = depth[2::8, 2::4]
    x, y = camera.rays()
    expected_w = -(plane.normal[0] * x[:, 2::4] + (plane.normal[1] * y[2::8] + plane.normal[2])) / plane.offset
    valid = sample > 0
    error = np.abs(1 / sample[valid] - expected_w[valid])
    noise, limit = expected, 6 * expected
    for _ in range(3):
        table = error[error < limit]
        if table.size == 0:
            break
        noise = 1.4826 * median(table)
        if noise < CUT_OFF * limit:
            break
        limit *= 2
    return noise


def _refitted(depth: FloatImage, camera: Intrinsics, plane: Plane, noise: float) -> Plane:
    """The plane through the largest piece of what lies within 2.5 ``noise`` of it; itself when that is small."""
    small = depth[::STRIDE, ::STRIDE]
    near = (np.abs(inverse_error(depth, camera, plane)) < 2.5 * noise) & (small > 0)
    count, pieces = cv2.connectedComponents(near.view(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    if count < 2:
        return plane
    v, u = np.nonzero(pieces == 1 + np.bincount(pieces.ravel(), minlength=count)[1:].argmax())
    if len(v) < 50:
        return plane
    columns, rows = camera.rays()
    rays = np.stack([columns[0, u * STRIDE], rows[v * STRIDE, 0], np.ones(len(u))], axis=1).astype(np.float64)
    solution, *_ = np.linalg.lstsq(rays, 1.0 / small[v, u].astype(np.float64), rcond=None)
    fit = np.asarray(solution, dtype=np.float64)
    length = float(np.linalg.norm(fit))
    return Plane(normal=-fit / length, offset=1.0 / length)
