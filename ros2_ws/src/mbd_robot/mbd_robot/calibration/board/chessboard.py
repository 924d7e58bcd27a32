"""A plain chessboard, which must be seen whole: it has nothing to tell its corners apart by."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import NOTHING, BoardPattern, FoundCorners
from mbd_robot.calibration.errors import CalibrationError

KIND = "chessboard"
# How findChessboardCornersSB is asked, one after the other: none of them finds every board.
LOOKS = (
    cv2.CALIB_CB_ACCURACY,
    cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY,
    cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE,
)


@dataclass(frozen=True)
class Chessboard(BoardPattern):
    """A chessboard as it was printed; its top left square is black.

    Attributes:
        columns: squares from left to right: one more than inner corners.
        rows: squares from top to bottom.
        square: side of a square [mm].

    Raises:
        CalibrationError: no such board can be printed, or one whose half turn looks like itself.
    """

    columns: int
    rows: int
    square: float
    form: ClassVar[str] = f"{KIND}:COLUMNSxROWS:SQUARE"

    def __post_init__(self) -> None:
        """Refuse what cannot be told from its half turn."""
        if min(self.columns, self.rows) < 4 or max(self.columns, self.rows) > 40:
            raise CalibrationError(f"a chessboard of {self.columns} x {self.rows} squares; expected 4 to 40 each way")
        if not 0.0 < self.square < 1000.0:
            raise CalibrationError(f"squares of {self.square:g} mm; expected millimetres")
        if (self.columns + self.rows) % 2 == 0:
            raise CalibrationError(
                f"a chessboard of {self.columns} x {self.rows} squares looks the same after half a turn, so that its "
                "pose stays open; take one with an even number of squares one way and an odd one the other "
                f"(such as {self.columns} x {self.rows + 1}), or a board with markers"
            )

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """(n, 3) inner corners row by row from the top left [m]."""
        rows, columns = np.mgrid[1 : self.rows, 1 : self.columns]
        flat = np.zeros(rows.size)
        return np.stack([columns.ravel() * self.square / 1000.0, rows.ravel() * self.square / 1000.0, flat], axis=1)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of all squares [mm]."""
        return self.columns * self.square, self.rows * self.square

    @property
    def described(self) -> str:
        """What a print shows, in words."""
        return f"{self.columns} x {self.rows} squares of {self.square:g} mm"

    def cells(self) -> list[tuple[float, float, float]]:
        """(left, top, side) of every black square [mm]."""
        return [(c * self.square, r * self.square, self.square) for r, c in np.argwhere(self._black)]

    @property
    def _black(self) -> NDArray[np.bool_]:
        """(rows, columns) which squares are."""
        rows, columns = np.indices((self.rows, self.columns))
        return np.asarray((rows + columns) % 2 == 0)

    def detected(self, grey: NDArray[np.uint8], *, thorough: bool) -> FoundCorners:
        """All corners, or none."""
        inner = (self.columns - 1, self.rows - 1)
        looks = (_by_sectors(grey, inner, flags) for flags in (LOOKS if thorough else LOOKS[:1]))
        found = next((f for f in looks if f is not None), None)
        if found is None and thorough:
            found = _by_squares(grey, inner)
        if found is None:
            return NOTHING
        pixels = _sharpened(grey, found)
        across, down = pixels[0, -1] - pixels[0, 0], pixels[-1, 0] - pixels[0, 0]
        if across[0] * down[1] - across[1] * down[0] < 0:  # a board is looked at from its front
            pixels = pixels[:, ::-1]
        if self._turned(grey, pixels):
            pixels = pixels[::-1, ::-1]
        return pixels.reshape(-1, 2), np.arange(pixels.shape[0] * pixels.shape[1], dtype=np.int64)

    def _turned(self, grey: NDArray[np.uint8], pixels: NDArray[np.float64]) -> bool:
        """Whether the squares that are black by this numbering are the bright ones: it is half a turn off."""
        middles = (pixels[:-1, :-1] + pixels[1:, :-1] + pixels[:-1, 1:] + pixels[1:, 1:]) / 4.0
        u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
        seen, black = grey[v, u], self._black[1:-1, 1:-1]
        return bool(seen[black].mean() > seen[~black].mean())

    def __str__(self) -> str:
        """As ``board_of`` reads it."""
        return f"{KIND}:{self.columns}x{self.rows}:{self.square:g}"


def _by_sectors(grey: NDArray[np.uint8], inner: tuple[int, int], flags: int) -> NDArray[np.float64] | None:
    """(rows, columns, 2) inner corners [px] by OpenCV's findChessboardCornersSB; None where not all are seen."""
    whole, found = cv2.findChessboardCornersSB(grey, inner, flags=flags)
    return np.asarray(found, dtype=np.float64).reshape(inner[1], inner[0], 2) if whole and found is not None else None


def _by_squares(grey: NDArray[np.uint8], inner: tuple[int, int]) -> NDArray[np.float64] | None:
    """The same by findChessboardCorners, which finds what the other misses."""
    whole, found = cv2.findChessboardCorners(grey, inner)
    return np.asarray(found, dtype=np.float64).reshape(inner[1], inner[0], 2) if whole and found is not None else None


def _sharpened(grey: NDArray[np.uint8], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The corners where black and white meet in them: either way of finding them is off by up to half a pixel."""
    side = min(float(np.linalg.norm(np.diff(corners, axis=axis), axis=2).min()) for axis in (0, 1))
    reach = int(np.clip(side / 3.0, 2.0, 8.0))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 30, 0.01)
    sharp = cv2.cornerSubPix(grey, corners.astype(np.float32).reshape(-1, 1, 2), (reach, reach), (-1, -1), stop)
    return np.asarray(sharp, dtype=np.float64).reshape(corners.shape)
