"""What every kind of printed board is to a calibration: numbered corners, found in a picture, and printed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

# (n, 2) pixels of corners and their numbers (n,).
FoundCorners = tuple[NDArray[np.float64], NDArray[np.int64]]
NOTHING: FoundCorners = (np.empty((0, 2)), np.empty(0, dtype=np.int64))


class BoardPattern(ABC):
    """A flat board. Its frame: x right, y down the print, z into the paper, origin at its top left; metres.

    Attributes:
        form: how its text reads, for people.
    """

    form: ClassVar[str]

    @property
    @abstractmethod
    def corners(self) -> NDArray[np.float64]:
        """(n, 3) corners by number [m]."""

    @property
    @abstractmethod
    def size(self) -> tuple[float, float]:
        """Width and height of what is printed [mm]."""

    @property
    @abstractmethod
    def described(self) -> str:
        """What a print shows, with the sides to measure, in words."""

    @abstractmethod
    def cells(self) -> list[tuple[float, float, float]]:
        """(left, top, side) of every black square of the print [mm]."""

    @abstractmethod
    def detected(self, grey: NDArray[np.uint8], *, thorough: bool) -> FoundCorners:
        """The corners that a picture shows.

        Args:
            grey: (H, W) uint8.
            thorough: look longer, for a picture that showed few.
        """

    @property
    def centre(self) -> NDArray[np.float64]:
        """(3,) its middle [m, board frame]."""
        return np.array([self.size[0] / 2000.0, self.size[1] / 2000.0, 0.0])

    @property
    def outline(self) -> NDArray[np.float64]:
        """(4, 3) its corners, clockwise from the top left [m, board frame]."""
        w, h = self.size[0] / 1000.0, self.size[1] / 1000.0
        return np.array([[0.0, 0.0, 0.0], [w, 0.0, 0.0], [w, h, 0.0], [0.0, h, 0.0]])

    def raster(self, pixels_per_mm: float, margin: float = 0.0) -> NDArray[np.uint8]:
        """(H, W) uint8 picture of the print, with ``margin`` [mm] of white around it."""
        width, height = (round((side + 2 * margin) * pixels_per_mm) for side in self.size)
        picture = np.full((height, width), 255, np.uint8)
        for left, top, side in self.cells():
            x, y, end_x, end_y = (round((v + margin) * pixels_per_mm) for v in (left, top, left + side, top + side))
            picture[y:end_y, x:end_x] = 0
        return picture
