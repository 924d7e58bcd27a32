"""A board by its text, as it is given to a command and kept in a file."""

from __future__ import annotations

from mbd_robot.calibration.board import april_grid, chessboard
from mbd_robot.calibration.board.april_grid import AprilGrid
from mbd_robot.calibration.board.chessboard import Chessboard
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.errors import CalibrationError


def board_of(text: str) -> BoardPattern:
    """The board that a text describes; sides in mm.

    Args:
        text: ``COLUMNSxROWS:SQUARE:MARKER:DICTIONARY[:legacy]`` (ChArUco), ``chessboard:COLUMNSxROWS:SQUARE`` (squares,
            not inner corners), or ``aprilgrid:COLUMNSxROWS:TAG:GAP`` (as Kalibr prints it).

    Raises:
        CalibrationError: it is none; says what was expected.
    """
    words = text.split(":")
    kind = words[0].lower()
    legacy = words[-1] == "legacy"
    words = words[:-1] if legacy else words
    try:
        if kind == chessboard.KIND:
            _, shape, square = words
            return Chessboard(*_shape(shape), float(square))
        if kind == april_grid.KIND:
            _, shape, tag, gap = words
            return AprilGrid(*_shape(shape), float(tag), float(gap))
        shape, square, marker, dictionary = words
        sides = float(square), float(marker)
        return PrintedBoard(*_shape(shape), *sides, dictionary.removeprefix("DICT_"), legacy)
    except ValueError as error:
        if isinstance(error, CalibrationError):
            raise
        forms = {chessboard.KIND: Chessboard.form, april_grid.KIND: AprilGrid.form}
        example = {chessboard.KIND: Chessboard(10, 7, 25.0), april_grid.KIND: AprilGrid(6, 6, 30.0, 9.0)}
        raise CalibrationError(
            f"'{text}' is no board; expected {forms.get(kind, PrintedBoard.form)} with sides in mm, such as "
            f"{example.get(kind, PrintedBoard())}"
        ) from None


def _shape(text: str) -> tuple[int, int]:
    columns, rows = (int(n) for n in text.lower().split("x"))
    return columns, rows
