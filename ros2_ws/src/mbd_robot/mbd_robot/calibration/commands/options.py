"""Options that several of the commands have."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from mbd_robot.calibration.board.april_grid import AprilGrid
from mbd_robot.calibration.board.chessboard import Chessboard
from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import read_lens
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.calibration.pairs.taken import PictureFolder


def add_board(parser: argparse.ArgumentParser) -> None:
    """``--board``."""
    parser.add_argument(
        "--board",
        metavar="BOARD",
        help=f"{PrintedBoard.form} (ChArUco), {Chessboard.form}, or {AprilGrid.form}: squares or tags each way, sides "
        f"in mm (the folder's, or {PrintedBoard()})",
    )


def add_table_height(parser: argparse.ArgumentParser) -> None:
    """``--table-height``."""
    parser.add_argument("--table-height", type=float, default=0.0, help="[m] of the table in the base frame (0)")


def add_folder(parser: argparse.ArgumentParser) -> None:
    """The folder of pictures, its lens and mounting."""
    parser.add_argument(
        "folder",
        type=Path,
        help="pictures and poses.csv (picture,x,y,z,qx,qy,qz,qw), or a folder of ada_ros2's samples",
    )
    add_board(parser)
    parser.add_argument(
        "--mounting", choices=[m.value for m in BoardMounting],
        help="where the board is: on the hand (the camera stands), or on the table (the camera is on the hand)",
    )  # fmt: skip
    parser.add_argument("--lens", type=Path, help="camera_calibration's YAML, or a camera_info (else the folder's)")


def taken_pictures(given: argparse.Namespace) -> tuple[PictureFolder, BoardPattern]:
    """The folder and the board of a command line; raises CalibrationError."""
    taken = read_pictures(given.folder)
    if given.lens:
        taken = replace(taken, lens=read_lens(given.lens))
    board = board_of(given.board) if given.board else taken.board or PrintedBoard()
    return taken, board


def mounting_of(given: argparse.Namespace, taken: PictureFolder) -> BoardMounting:
    """Which of camera and board moved; raises CalibrationError where neither the words nor the folder say."""
    if given.mounting:
        return BoardMounting(given.mounting)
    if taken.mounting is None:
        raise CalibrationError(
            f"{taken.folder} does not say where the board was; give --mounting hand (the camera stands) or "
            "--mounting table (the camera is on the hand)"
        )
    return taken.mounting
