"""A printed ChArUco board: a chessboard whose white squares hold markers, so that each corner is known by number."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import cv2
import numpy as np
from mbd_model.parameters import nearest
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import NOTHING, BoardPattern, FoundCorners
from mbd_robot.calibration.errors import CalibrationError

DICTIONARIES = (
    *(f"{bits}X{bits}_{count}" for bits in (4, 5, 6, 7) for count in (50, 100, 250, 1000)),
    "APRILTAG_36h11",
)

GAMMA = 2.0  # that darkens


@dataclass(frozen=True)
class PrintedBoard(BoardPattern):
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
    form: ClassVar[str] = "COLUMNSxROWS:SQUARE:MARKER:DICTIONARY"

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
    def described(self) -> str:
        """What a print shows, in words."""
        return f"{self.columns} x {self.rows} squares of {self.square:g} mm"

    def detected(self, grey: NDArray[np.uint8], *, thorough: bool) -> FoundCorners:
        """The corners whose markers are seen.

        Thorough is for small markers and white that outshines them, as on real pictures of a glossy print: twice as
        large, darker, and with the markers searched where the others say that they are.
        """
        parameters, rules = cv2.aruco.DetectorParameters(), cv2.aruco.CharucoParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        scale = 1
        if thorough:
            scale, rules.tryRefineMarkers, parameters.minMarkerPerimeterRate = 2, True, 0.02
            darker = cv2.LUT(grey, (255.0 * (np.arange(256) / 255.0) ** GAMMA).astype(np.uint8))
            larger = cv2.resize(darker, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
            grey = np.asarray(larger, dtype=np.uint8)
        found, numbers, _, _ = cv2.aruco.CharucoDetector(self.pattern, rules, parameters).detectBoard(grey)
        if numbers is None:
            return NOTHING
        pixels = (np.asarray(found, dtype=np.float64).reshape(-1, 2) + 0.5) / scale - 0.5
        return pixels, np.asarray(numbers, dtype=np.int64).reshape(-1)

    def drawn(self, pixels_per_square: int, margin: int = 0) -> NDArray[np.uint8]:
        """(H, W) uint8 picture of the board, with a white margin [px] around it."""
        size = (self.columns * pixels_per_square + 2 * margin, self.rows * pixels_per_square + 2 * margin)
        return np.asarray(self.pattern.generateImage(size, marginSize=margin, borderBits=1), dtype=np.uint8)

    def __str__(self) -> str:
        """As ``board_of`` reads it."""
        legacy = ":legacy" if self.legacy else ""
        return f"{self.columns}x{self.rows}:{self.square:g}:{self.marker:g}:{self.dictionary}{legacy}"
