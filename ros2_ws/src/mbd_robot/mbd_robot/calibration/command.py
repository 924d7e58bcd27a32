"""Where the camera stands: print a board, take pictures of it, find the pose and its error, check it.

calibrate board --out board.pdf                          a board to print
calibrate take --robot ur5e --camera realsense --out A   pictures and tool poses, with robot and camera running
calibrate solve A --out camera.yaml                      the pose, how far off it may be, and the session's file
calibrate touch A --touched touched.csv --out FILE       the same of a board on the table, touched by the tool
calibrate check A --pose camera.yaml --out check.png     table, tool and arm drawn in a picture, and millimetres
calibrate trials                                         how often the stated error holds, on synthetic pictures
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence

from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError

from mbd_robot.calibration.commands import check, print_board, solve, take, touch, trials

COMMANDS = {"board": print_board, "take": take, "solve": solve, "touch": touch, "check": check, "trials": trials}


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 1 for what cannot be used or calibrated."""
    parser = CommandParser(prog="calibrate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, module in COMMANDS.items():
        first = (module.__doc__ or "").splitlines()[0]
        module.arguments(kinds.add_parser(name, description=first, help=first))
    arguments = parser.parse_args(words)
    run: Callable[[argparse.Namespace], int] = COMMANDS[arguments.command].run
    try:
        sys.exit(run(arguments))
    except MbdError as error:
        sys.stderr.write(f"calibrate {arguments.command}: {error}\n")
        sys.exit(1)


if __name__ == "__main__":
    main()
