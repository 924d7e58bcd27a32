"""Faces in a picture, by the detector that comes with dlib: histograms of gradients of frontal faces, five views.

It is looked for them in four turns of the picture, since whoever leans over a table is seen from any side by a camera
above it. What looks away, is in profile or half covered is not found.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from mbd_bag.errors import BagError
from numpy.typing import NDArray

SMALLEST = 80.0  # [px] that the detector was trained for
SCALES = (0.25, 2.0)  # of the picture that is looked at
SCORE = 0.1  # at least; a portrait turned by any angle has 1.0 and more, of 55 real tables one has 0.0, the others none
AROUND = 0.45  # of a found box's side: it ends at brows and chin, a face does not


@dataclass(frozen=True)
class FaceBox:
    """A rectangle of a picture [px], first pixel and the one behind the last."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def part(self) -> tuple[slice, slice]:
        """Its rows and columns."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


class FaceFinder:
    """Finds faces.

    Raises:
        BagError: dlib is not installed.
    """

    def __init__(self) -> None:
        try:
            import dlib  # only who shares pictures needs it
        except ImportError as error:
            raise BagError(
                "looking for faces needs dlib, which is not installed: install dlib-bin as requirements/recordings.txt "
                "names it, or share without --cameras"
            ) from error
        self._detector: Any = dlib.get_frontal_face_detector()

    def find(self, picture: NDArray[np.uint8], least: float) -> list[FaceBox]:
        """The faces in a picture, with what is around them.

        Args:
            picture: (height, width) grey.
            least: width of the faces that are looked for [px]; of narrower ones some are found.
        """
        height, width = picture.shape
        scale = float(np.clip(SMALLEST / max(least, 1.0), *SCALES))
        size = (max(round(scale * width), 1), max(round(scale * height), 1))
        how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        looked = cv2.resize(picture, size, interpolation=how)
        found = []
        for turns in range(4):
            turned = np.ascontiguousarray(np.rot90(looked, turns))
            for box in self._detector.run(turned, 0, SCORE)[0]:
                corners = np.array([(box.top(), box.left()), (box.bottom(), box.right())], np.float64)
                found.append(_in_picture(corners, turned.shape, turns, scale, picture.shape))
        return found


def _in_picture(
    corners: NDArray[np.float64], turned: tuple[int, ...], turns: int, scale: float, size: tuple[int, ...]
) -> FaceBox:
    """A box of the turned, scaled picture as one of the picture, enlarged; ``corners``: two of (row, column)."""
    rows, columns = corners[:, 0], corners[:, 1]
    height, width = turned
    for _ in range(turns):  # np.rot90 took (row, column) to (width - 1 - column, row)
        rows, columns = columns, height - 1 - rows
        height, width = width, height
    more = AROUND * float(np.ptp(columns))
    top, bottom = (rows.min() - more) / scale, (rows.max() + more) / scale
    left, right = (columns.min() - more) / scale, (columns.max() + more) / scale
    bounds = np.clip([top, bottom + 1], 0, size[0]), np.clip([left, right + 1], 0, size[1])
    (top, bottom), (left, right) = bounds
    return FaceBox(int(top), int(left), int(np.ceil(bottom)), int(np.ceil(right)))
