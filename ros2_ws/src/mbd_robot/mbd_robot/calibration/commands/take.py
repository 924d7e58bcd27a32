"""Pictures with their tool poses, one whenever the hand rests somewhere new; robot and camera must be running."""

from __future__ import annotations

import argparse
from pathlib import Path

from mbd_model.command_line.values import at_least_one

from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.commands.options import add_board, add_table_height
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.writing import refuse_used

COUNT = 15


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    parser.add_argument("--out", type=Path, required=True, help="new folder for pictures and poses")
    parser.add_argument(
        "--mounting", choices=[m.value for m in BoardMounting], default="hand", help="where the board is"
    )
    parser.add_argument(
        "--count", type=at_least_one, default=COUNT, help=f"pictures to take (default {COUNT}); Ctrl-C ends before"
    )
    parser.add_argument("--any", action="store_true", help="take pictures without a board, too: for `check`")
    add_table_height(parser)
    add_board(parser)


def run(given: argparse.Namespace) -> int:
    """Take them; raises MbdError when the folder is not new or nothing arrives."""
    # Here, not above: all other commands work where there is no ROS.
    from mbd_robot.ros.calibration.picture_collector import PictureTaking
    from mbd_robot.ros.calibration.picture_taking import take_pictures

    refuse_used(given.out)
    board = board_of(given.board) if given.board else PrintedBoard()
    wanted = PictureTaking(
        given.out, board, BoardMounting(given.mounting), given.count, not given.any, given.table_height
    )  # fmt: skip
    return take_pictures(wanted)
