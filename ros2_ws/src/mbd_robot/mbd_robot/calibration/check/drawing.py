"""Table, frames and arm drawn into a picture, where a camera pose says that they are."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.check.table import TableArea
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.transforms import Transforms, inverse

Color = tuple[int, int, int]
TABLE: Color = (255, 200, 0)
ARM: Color = (0, 200, 255)
BOARD: Color = (255, 0, 200)
AXES: tuple[Color, Color, Color] = ((255, 60, 60), (60, 220, 60), (80, 120, 255))
GRID = 0.1  # [m]
STEPS = 40  # of a line, so that the part behind the camera can be left out
PLACES = 4  # bits of a pixel's fraction in OpenCV's drawing


class PictureDrawing:
    """Draws points of the base frame into a picture.

    Args:
        picture: (H, W) grey or (H, W, 3) RGB; it is copied.
        lens: it was taken with.
        camera2base: (4, 4).
    """

    def __init__(self, picture: NDArray[np.uint8], lens: CalibratedLens, camera2base: Transforms) -> None:
        colored = cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB) if picture.ndim == 2 else picture.copy()
        self.picture = np.ascontiguousarray(colored)
        self._lens, self._base2camera = lens, inverse(camera2base)

    def table(self, area: TableArea) -> None:
        """Outline of the area and a grid of 10 cm."""
        z = area.height
        for x in np.arange(np.ceil(area.x[0] / GRID) * GRID, area.x[1], GRID):
            self.line(np.array([[x, area.y[0], z], [x, area.y[1], z]]), TABLE, 1, faint=True)
        for y in np.arange(np.ceil(area.y[0] / GRID) * GRID, area.y[1], GRID):
            self.line(np.array([[area.x[0], y, z], [area.x[1], y, z]]), TABLE, 1, faint=True)
        self.line(np.vstack((area.outline, area.outline[:1])), TABLE, 2)

    def frame(self, pose: Transforms, length: float, name: str) -> None:
        """Axes of a frame (4, 4) in the base frame: x red, y green, z blue, ``length`` [m] long."""
        for axis, color in enumerate(AXES):
            self.line(np.stack((pose[:3, 3], pose[:3, 3] + length * pose[:3, axis])), color, 2)
        self.text(pose[:3, 3], name)

    def outline(self, points: NDArray[np.float64], color: Color = ARM) -> None:
        """The outline of a shape, by (n, 3) points of its surface [m, base frame]."""
        pixels = self._pixels(points)
        if not np.isfinite(pixels).all():
            return
        hull = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2)
        self._draw(np.vstack((hull, hull[:1])), color, 1)

    def line(self, points: NDArray[np.float64], color: Color, width: int, faint: bool = False) -> None:
        """Lines through (n, 3) points [m, base frame], without what lies behind the camera."""
        before = self.picture.copy() if faint else None
        for start, end in pairwise(points):
            shares = np.linspace(0.0, 1.0, STEPS)[:, None]
            pixels = self._pixels(start + shares * (end - start))
            kept = pixels[np.isfinite(pixels).all(axis=1) & (np.abs(pixels) < 1e4).all(axis=1)]
            if len(kept) > 1:
                self._draw(kept, color, width)
        if before is not None:
            self.picture = np.asarray(cv2.addWeighted(self.picture, 0.5, before, 0.5, 0.0), dtype=np.uint8)

    def text(self, place: NDArray[np.float64], words: str) -> None:
        """Words at a point (3,) [m, base frame]."""
        pixel = self._pixels(place[None])[0]
        if np.isfinite(pixel).all() and (np.abs(pixel) < 1e4).all():
            at = (int(pixel[0]) + 6, int(pixel[1]) - 6)
            cv2.putText(self.picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 3, cv2.LINE_AA)
            cv2.putText(self.picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1, cv2.LINE_AA)

    def legend(self, lines: Sequence[str]) -> None:
        """Words at the picture's lower left."""
        for i, words in enumerate(reversed(lines)):
            at = (8, self.picture.shape[0] - 8 - 18 * i)
            cv2.putText(self.picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 3, cv2.LINE_AA)
            cv2.putText(self.picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (255, 255, 255), 1, cv2.LINE_AA)

    def _pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        seen = points @ self._base2camera[:3, :3].T + self._base2camera[:3, 3]
        seen[seen[:, 2] < 0.02] = np.nan
        return self._lens.project(seen)

    def _draw(self, pixels: NDArray[np.float64], color: Color, width: int) -> None:
        whole = np.round(pixels * 2**PLACES).astype(np.int32)
        cv2.polylines(self.picture, [whole], False, color, width, cv2.LINE_AA, PLACES)
