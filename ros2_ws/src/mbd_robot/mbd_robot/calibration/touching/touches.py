"""Corners of a board that were touched by the tool, as a file lists them.

corner,x,y,z,qx,qy,qz,qw       corner: top_left, top_right, bottom_right, bottom_left (of all squares) or a number
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.errors import CalibrationError

OUTER = ("top_left", "top_right", "bottom_right", "bottom_left")
TURN = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class Touch:
    """One corner and where the tip was that touched it.

    Attributes:
        corner: its name or number.
        point: (3,) [m, board frame].
        place: (3,) [m, base frame].
    """

    corner: str
    point: NDArray[np.float64]
    place: NDArray[np.float64]


def read_touches(file: Path, board: BoardPattern, tip: float) -> list[Touch]:
    """The touches of a file.

    Args:
        file: CSV; the tool's pose at each touch. Without a quaternion the tool pointed straight down.
        board: that was touched.
        tip: [m] how far beyond the tool's point, along the fingers, the tip is that touched.

    Raises:
        CalibrationError: no such file or corner, or no numbers; states the line.
    """
    try:
        reader = csv.DictReader(io.StringIO(file.read_text(encoding="utf-8-sig")), skipinitialspace=True)
        rows = [(reader.line_num, {str(k).strip(): v for k, v in row.items()}) for row in reader]
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{file} cannot be read: {error}") from error
    return [_touch(f"{file} line {line}", row, board, tip) for line, row in rows]


def _touch(where: str, row: dict[str, str], board: BoardPattern, tip: float) -> Touch:
    corner = (row.get("corner") or "").strip()
    inner = len(board.corners)
    if corner in OUTER:
        point = board.outline[OUTER.index(corner)]
    elif corner.isdecimal() and int(corner) < inner:
        point = board.corners[int(corner)]
    else:
        raise CalibrationError(f"{where}: corner '{corner}'; expected {', '.join(OUTER)}, or 0 to {inner - 1}")
    try:
        place = np.array([float(row[k]) for k in "xyz"])
        turned = [row.get(k) for k in TURN]
        quaternion = np.array([float(v) for v in turned if v is not None]) if all(turned) else None
    except (KeyError, TypeError, ValueError):
        raise CalibrationError(f"{where}: expected numbers in x,y,z and, where given, qx,qy,qz,qw [m]") from None
    down = np.array([0.0, 0.0, -1.0])
    if quaternion is not None:
        if not abs(np.linalg.norm(quaternion) - 1.0) < 0.05:
            raise CalibrationError(f"{where}: the quaternion has length {np.linalg.norm(quaternion):.2f}; expected 1")
        down = Rotation.from_quat(quaternion).as_matrix()[:, 2]
    if not np.isfinite(place).all():
        raise CalibrationError(f"{where}: a number is not finite; expected metres")
    return Touch(corner, point, place + tip * down)
