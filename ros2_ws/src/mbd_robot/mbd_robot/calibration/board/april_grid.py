"""A grid of AprilTags as Kalibr prints it: each tag is known by number, and black squares make its corners sharp."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import NOTHING, BoardPattern, FoundCorners
from mbd_robot.calibration.errors import CalibrationError

KIND = "aprilgrid"
BORDER = 2  # bits of black around a tag's own, as kalibr_create_target_pdf draws it
BITS = 6 + 2 * BORDER
MOST = 587  # tags of the family 36h11
WINDOW = 0.5  # share of the gap in the picture within which a corner is looked for
LOOSE = 3.0  # [px] by which a corner may be off where the others put it, lens and all
CELL = 6  # [px] of a bit, upright
CONTRAST, ALIKE = 15.0, 0.95  # grey levels between white and black; share of the bits that must be right
# Kalibr's tags are OpenCV's turned by half: the marker's first corner is the print's lower right one.
ORDER = (2, 3, 0, 1)


@dataclass(frozen=True)
class AprilGrid(BoardPattern):
    """A grid as it was printed: family 36h11, numbered from the lower left tag to the right, then up.

    Attributes:
        columns: tags from left to right.
        rows: tags from bottom to top.
        tag: side of a tag with its black border [mm].
        gap: between two tags [mm]; Kalibr's tagSpacing times the side.

    Raises:
        CalibrationError: no such grid can be printed.
    """

    columns: int
    rows: int
    tag: float
    gap: float
    form: ClassVar[str] = f"{KIND}:COLUMNSxROWS:TAG:GAP"

    def __post_init__(self) -> None:
        """Refuse what cannot be printed."""
        if min(self.columns, self.rows) < 1 or not 2 <= self.columns * self.rows <= MOST:
            raise CalibrationError(f"a grid of {self.columns} x {self.rows} tags; expected 2 to {MOST} tags")
        if not 0.0 < self.gap < self.tag < 1000.0:
            raise CalibrationError(
                f"tags of {self.tag:g} mm with gaps of {self.gap:g} mm; expected millimetres, gaps smaller than tags"
            )

    @cached_property
    def _family(self) -> Any:
        return cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)

    def _place(self, number: int) -> tuple[float, float]:
        """Left and top of a tag [mm]."""
        row, column = divmod(number, self.columns)
        pitch = self.tag + self.gap
        return self.gap + column * pitch, self.gap + (self.rows - 1 - row) * pitch

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """(4 n, 3) corners of each tag in turn, clockwise from its top left [m]."""
        points = []
        for number in range(self.columns * self.rows):
            x, y = self._place(number)
            t = self.tag
            points += [(x, y, 0.0), (x + t, y, 0.0), (x + t, y + t, 0.0), (x, y + t, 0.0)]
        return np.array(points) / 1000.0

    @property
    def size(self) -> tuple[float, float]:
        """Width and height with the squares at the outer corners [mm]."""
        return (
            self.columns * (self.tag + self.gap) + self.gap,
            self.rows * (self.tag + self.gap) + self.gap,
        )

    @property
    def described(self) -> str:
        """What a print shows, in words."""
        return f"{self.columns} x {self.rows} tags of {self.tag:g} mm with gaps of {self.gap:g} mm"

    def cells(self) -> list[tuple[float, float, float]]:
        """(left, top, side) of every black square of the print [mm]."""
        side, pitch = self.tag / BITS, self.tag + self.gap
        cells = [(c * pitch, r * pitch, self.gap) for r in range(self.rows + 1) for c in range(self.columns + 1)]
        for number in range(self.columns * self.rows):
            left, top = self._place(number)
            cells += [(left + c * side, top + r * side, side) for r, c in np.argwhere(~self._bits(number))]
        return cells

    def detected(self, grey: NDArray[np.uint8], *, thorough: bool) -> FoundCorners:
        """The corners of the tags that are seen whole."""
        tags: dict[int, NDArray[np.float64]] = {}
        for picture, scale, by_edges in _looks(grey, thorough):
            for number, corners in self._tags(picture, by_edges).items():
                tags.setdefault(number, (corners + 0.5) / scale - 0.5)
        if not tags:
            return NOTHING
        sharp = {number: self._sharpened(grey, corners) for number, corners in tags.items()}
        sharp |= self._foretold(grey, sharp)
        numbers = np.concatenate([4 * number + np.arange(4) for number in sharp])
        return np.concatenate(list(sharp.values())), numbers.astype(np.int64)

    def _tags(self, picture: NDArray[np.uint8], by_edges: bool) -> dict[int, NDArray[np.float64]]:
        """(4, 2) corners of each tag of the grid that is found in a picture, clockwise from its top left [px]."""
        parameters = cv2.aruco.DetectorParameters()
        parameters.markerBorderBits, parameters.minMarkerPerimeterRate = BORDER, 0.02
        if by_edges:
            parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_APRILTAG
        found, numbers, _ = cv2.aruco.ArucoDetector(self._family, parameters).detectMarkers(picture)
        if numbers is None:
            return {}
        known = zip(numbers.reshape(-1).tolist(), found, strict=True)
        own = ((number, marker) for number, marker in known if number < self.columns * self.rows)
        return {number: np.asarray(marker, dtype=np.float64).reshape(4, 2)[list(ORDER)] for number, marker in own}

    def _foretold(
        self, grey: NDArray[np.uint8], tags: dict[int, NDArray[np.float64]]
    ) -> dict[int, NDArray[np.float64]]:
        """The corners of the other tags that are where those found put them, and show their own bits."""
        plane = self.corners[:, :2].reshape(-1, 4, 2)
        known = np.concatenate([plane[number] for number in tags])
        to_picture, _ = cv2.findHomography(known, np.concatenate(list(tags.values())), cv2.RANSAC, LOOSE)
        if to_picture is None:
            return {}
        more = {}
        for number in set(range(len(plane))) - set(tags):
            corners = cv2.perspectiveTransform(plane[number][None], to_picture)[0]
            if corners.min() < 1.0 or (corners > np.array(grey.shape[::-1]) - 2.0).any():
                continue
            sharp = self._sharpened(grey, corners)
            if np.abs(sharp - corners).max() <= LOOSE and self._shows(grey, sharp, number):
                more[number] = sharp
        return more

    def _shows(self, grey: NDArray[np.uint8], corners: NDArray[np.float64], number: int) -> bool:
        """Whether a tag's bits are seen between these corners."""
        side = BITS * CELL
        square = np.array([[0, 0], [side, 0], [side, side], [0, side]], np.float32) - 0.5
        upright = cv2.getPerspectiveTransform(corners.astype(np.float32), square)
        flat = cv2.warpPerspective(grey, upright, (side, side))
        cells = flat.reshape(BITS, CELL, BITS, CELL)[:, 1:-1, :, 1:-1].mean(axis=(1, 3))
        wanted = self._bits(number)
        dark, bright = cells[~wanted].mean(), cells[wanted].mean()
        return bool(bright - dark > CONTRAST and ((cells > (dark + bright) / 2.0) == wanted).mean() >= ALIKE)

    def _bits(self, number: int) -> NDArray[np.bool_]:
        """(BITS, BITS) which cells of a tag are white."""
        picture = np.asarray(cv2.aruco.generateImageMarker(self._family, number, BITS, None, BORDER), np.uint8)
        return np.rot90(picture, 2) > 0

    def _sharpened(self, grey: NDArray[np.uint8], corners: NDArray[np.float64]) -> NDArray[np.float64]:
        """(4, 2) corners of a tag where its black meets that of the squares [px]."""
        side = float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).min())
        reach = int(np.clip(WINDOW * side * self.gap / self.tag, 2.0, 8.0))
        stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 30, 0.01)
        points = corners.astype(np.float32).reshape(-1, 1, 2)
        return np.asarray(cv2.cornerSubPix(grey, points, (reach, reach), (-1, -1), stop), np.float64).reshape(4, 2)

    def __str__(self) -> str:
        """As ``board_of`` reads it."""
        return f"{KIND}:{self.columns}x{self.rows}:{self.tag:g}:{self.gap:g}"


def _looks(grey: NDArray[np.uint8], thorough: bool) -> Iterator[tuple[NDArray[np.uint8], int, bool]]:
    """(picture, its scale, whether tags are looked for by edges): what one look misses another finds.

    The squares at a tag's corners touch it, so that its outline goes on around them: white grown by a pixel parts them.
    """
    yield cv2.dilate(grey, np.ones((2, 2), np.uint8)).astype(np.uint8), 1, False
    yield cv2.resize(grey, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC).astype(np.uint8), 2, False
    if thorough:
        yield grey, 1, True
