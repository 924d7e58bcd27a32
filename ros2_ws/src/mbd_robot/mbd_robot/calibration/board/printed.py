"""A printed ChArUco board: a chessboard whose white squares hold markers, so that each corner is known by number."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from mbd_model.parameters import nearest
from numpy.typing import NDArray

from mbd_robot.calibration.errors import CalibrationError

DICTIONARIES = (
    *(f"{bits}X{bits}_{count}" for bits in (4, 5, 6, 7) for count in (50, 100, 250, 1000)),
    "APRILTAG_36h11",
)


@dataclass(frozen=True)
class PrintedBoard:
    """A board as it was printed.

    Attributes:
        columns: squares from left to right.
        rows: squares from top to bottom.
        square: side of a square [mm].
        marker: side of a marker [mm].
        dictionary: of its markers, a name of OpenCV's without DICT_.
        legacy: printed by OpenCV before 4.6, which began boards of an even number of rows with a white square.

    Raises:
        CalibrationError: no such board can be printed.
    """

    columns: int = 8
    rows: int = 6
    square: float = 25.0
    marker: float = 18.0
    dictionary: str = "5X5_100"
    legacy: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be printed."""
        if min(self.columns, self.rows) < 3 or max(self.columns, self.rows) > 40:
            raise CalibrationError(f"a board of {self.columns} x {self.rows} squares; expected 3 to 40 each way")
        if not 0.0 < self.marker < self.square < 1000.0:
            raise CalibrationError(
                f"squares of {self.square:g} mm with markers of {self.marker:g} mm; expected millimetres, and markers "
                "smaller than their squares"
            )
        if self.dictionary not in DICTIONARIES:
            near = nearest(self.dictionary.removeprefix("DICT_"), DICTIONARIES)
            advice = f"did you mean {near}?" if near else f"expected one of {', '.join(DICTIONARIES)}"
            raise CalibrationError(f"no dictionary of markers '{self.dictionary}'; {advice}")
        held = self._dictionary().bytesList.shape[0]
        if self.columns * self.rows // 2 > held:
            raise CalibrationError(
                f"{self.columns} x {self.rows} squares need {self.columns * self.rows // 2} markers, and "
                f"{self.dictionary} has {held}; take a dictionary of more"
            )

    def _dictionary(self) -> Any:
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{self.dictionary}"))

    @cached_property
    def pattern(self) -> Any:
        """OpenCV's CharucoBoard, in metres."""
        made = cv2.aruco.CharucoBoard(
            (self.columns, self.rows), self.square / 1000.0, self.marker / 1000.0, self._dictionary()
        )
        if self.legacy:
            made.setLegacyPattern(True)
        return made

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """(n, 3) inner corners by number [m]: x right, y down the print, z into the paper, origin at its top left."""
        return np.asarray(self.pattern.getChessboardCorners(), dtype=np.float64)

    def cells(self) -> list[tuple[float, float, float]]:
        """(left, top, side) of every black square of the print [mm], those of the markers included."""
        dictionary = self._dictionary()
        bits = dictionary.markerSize + 2
        side = self.marker / bits
        white, cells = set(), []
        for marker, corners in zip(self.pattern.getIds().reshape(-1), self.pattern.getObjPoints(), strict=True):
            left, top = (float(v) * 1000.0 for v in corners[0][:2])
            white.add((int(left // self.square), int(top // self.square)))
            picture = cv2.aruco.generateImageMarker(dictionary, int(marker), bits)
            cells += [(left + c * side, top + r * side, side) for r, c in np.argwhere(picture == 0)]
        squares = [(c, r) for c in range(self.columns) for r in range(self.rows) if (c, r) not in white]
        return cells + [(c * self.square, r * self.square, self.square) for c, r in squares]

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of all squares [mm]."""
        return self.columns * self.square, self.rows * self.square

    @property
    def centre(self) -> NDArray[np.float64]:
        """(3,) its middle [m, board frame]."""
        return np.array([self.size[0] / 2000.0, self.size[1] / 2000.0, 0.0])

    @property
    def outline(self) -> NDArray[np.float64]:
        """(4, 3) its corners, clockwise from the top left [m, board frame]."""
        w, h = self.size[0] / 1000.0, self.size[1] / 1000.0
        return np.array([[0.0, 0.0, 0.0], [w, 0.0, 0.0], [w, h, 0.0], [0.0, h, 0.0]])

    def drawn(self, pixels_per_square: int, margin: int = 0) -> NDArray[np.uint8]:
        """(H, W) uint8 picture of the board, with a white margin [px] around it."""
        size = (self.columns * pixels_per_square + 2 * margin, self.rows * pixels_per_square + 2 * margin)
        return np.asarray(self.pattern.generateImage(size, marginSize=margin, borderBits=1), dtype=np.uint8)

    def __str__(self) -> str:
        """As ``board_of`` reads it."""
        legacy = ":legacy" if self.legacy else ""
        return f"{self.columns}x{self.rows}:{self.square:g}:{self.marker:g}:{self.dictionary}{legacy}"


def board_of(text: str) -> PrintedBoard:
    """The board that ``COLUMNSxROWS:SQUARE:MARKER:DICTIONARY[:legacy]`` describes, sides in mm.

    Raises:
        CalibrationError: it is none; says what was expected.
    """
    words = text.split(":")
    legacy = words[-1] == "legacy"
    words = words[:-1] if legacy else words
    try:
        shape, square, marker, dictionary = words
        columns, rows = (int(n) for n in shape.lower().split("x"))
        sides = float(square), float(marker)
    except ValueError:
        raise CalibrationError(
            f"'{text}' is no board; expected COLUMNSxROWS:SQUARE:MARKER:DICTIONARY with sides in mm, such as "
            f"{PrintedBoard()}"
        ) from None
    return PrintedBoard(columns, rows, *sides, dictionary.removeprefix("DICT_"), legacy)
