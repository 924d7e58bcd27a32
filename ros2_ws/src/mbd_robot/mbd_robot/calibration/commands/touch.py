"""The camera's pose by a board on the table whose corners the tool touched; writes the session's file."""

from __future__ import annotations

import argparse
import sys
from datetime import datetime
from pathlib import Path

import cv2
import numpy as np
from mbd_model.errors import MbdError

from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.board.views import FINEST, find_corners, view_of
from mbd_robot.calibration.camera_file import write_camera_file
from mbd_robot.calibration.commands.options import add_board, add_table_height
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens, read_lens
from mbd_robot.calibration.solving.certainty import bound, table_points
from mbd_robot.calibration.touching.fitting import TouchedFit, fit_touches
from mbd_robot.calibration.touching.touches import read_touches

TIP = 0.014  # [m] closed fingers beyond the tool's point, as docs/robot.md has it


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    parser.add_argument("picture", type=Path, nargs="+", help="of the board where it lies, by the camera that stands")
    parser.add_argument(
        "--touched", type=Path, required=True,
        help="CSV: corner,x,y,z[,qx,qy,qz,qw]: the tool's pose at each (top_left, ..., or an inner one's number)",
    )  # fmt: skip
    parser.add_argument("--lens", type=Path, required=True, help="camera_calibration's YAML, or a camera_info")
    parser.add_argument(
        "--tip", type=float, default=TIP, help=f"[m] of the tip beyond the tool's point (default {TIP})"
    )
    add_table_height(parser)
    parser.add_argument("--out", type=Path, help="camera file to write, for camera_file:= of a session")
    add_board(parser)


def run(given: argparse.Namespace) -> int:
    """Solve, report, write; raises MbdError when any of it cannot be done."""
    if given.out and given.out.exists():
        raise MbdError(f"{given.out} is there already, and nothing is overwritten; give another name")
    board = board_of(given.board) if given.board else PrintedBoard()
    lens = read_lens(given.lens)
    touches = read_touches(given.touched, board, given.tip)
    views = []
    for file in given.picture:
        pixels = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        if pixels is None:
            raise CalibrationError(f"{file} is no picture that can be read; expected PNG or JPEG")
        corners = find_corners(np.asarray(pixels, dtype=np.uint8), board, lens)
        view = view_of(corners, board, lens) if corners else None
        if view is None:
            raise CalibrationError(f"the board {board} is not in {file}; is --board what was printed?")
        views.append(view)
    noise = float(np.sqrt(sum(v.squares for v in views) / sum(v.freedom for v in views)))
    found = fit_touches(touches, views, max(noise, FINEST))
    lines = list(_words(found, lens, noise, given.table_height))
    sys.stdout.write("\n".join(lines) + "\n")
    if given.out:
        write_camera_file(given.out, found.fit.x, ("", ""), lines[-1:], datetime.now())
        sys.stdout.write(f"written: {given.out}\n")
    return 0


def _words(found: TouchedFit, lens: CalibratedLens, noise: float, height: float) -> list[str]:
    fit = found.fit
    lines = [f"{len(found.off)} touches fit the board to {fit.place_noise * 1000:.1f} mm, corners to {noise:.2f} px"]
    lines += [f"  left out: {corner}: {off * 1000:.0f} mm off by the others" for corner, off in found.wrong.items()]
    tilt = np.degrees(np.arccos(min(abs(float(fit.y[2, 2])), 1.0)))
    lines.append(
        f"the board lies {fit.y[2, 3] * 1000:.1f} mm high at its top left, tilted by {tilt:.1f} deg: on a level table "
        f"at {height:g} m both are near 0, or --tip is wrong"
    )
    points = table_points(lens, fit.x, height)
    x, y, z = fit.x[:3, 3]
    at = bound(fit, points[0]) if len(points) else bound(fit, fit.x[:3, :3].T @ (fit.y[:3, 3] - fit.x[:3, 3]))
    lines.append(f"camera2base: ({x:.4f}, {y:.4f}, {z:.4f}) m")
    lines.append(
        f"With 95 % probability a point where the camera looks is put within {at * 1000:.1f} mm of where it is; the "
        f"camera itself within {bound(fit, np.zeros(3)) * 1000:.1f} mm."
    )
    return lines
