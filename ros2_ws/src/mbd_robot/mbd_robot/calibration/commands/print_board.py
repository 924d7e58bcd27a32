"""A ChArUco board to print at its true size."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.board.printing import print_board
from mbd_robot.calibration.commands.options import add_board


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    parser.add_argument("--out", type=Path, required=True, help="file to write: .pdf, .svg or .png")
    add_board(parser)


def run(given: argparse.Namespace) -> int:
    """Write the board; raises MbdError when it cannot be."""
    board = board_of(given.board) if given.board else PrintedBoard()
    sys.stdout.write(print_board(board, given.out) + "\n")
    return 0
