"""Pictures and tool poses for `calibrate solve` out of a bag: one wherever the hand rested before the camera."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from mbd_bag.session.command_line import bag_parser, run_tool
from mbd_bag.storage.bag import Bag
from mbd_model.errors import MbdError
from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.writing import refuse_used
from mbd_robot.images import decode_color
from mbd_robot.profiles.camera import COLOR, DEPTH, INFO
from mbd_robot.ros.calibration.picture_collector import PictureCollector, PictureTaking
from mbd_robot.ros.camera_node import image_msg
from mbd_robot.topics import JOINT_STATE, TOOL_POSE

MOST = 200  # pictures


def collect(bag: Bag, taking: PictureTaking, topics: argparse.Namespace, say: Callable[[str], None]) -> int:
    """Write the pictures; returns how many.

    Args:
        bag: to read.
        taking: what to look for.
        topics: ``color``, ``depth``, ``info``, ``tool_pose``, ``joint_state``: their names in the bag.
        say: takes each line for people.

    Raises:
        MbdError: the bag lacks a topic that is needed, or a message cannot be read.
    """
    collector = PictureCollector(taking, say)
    names = {t.name.lstrip("/"): t.name for t in bag.topics}
    compressed = f"{topics.color}/compressed"

    def decompressed(msg: Any) -> None:
        collector.on_color(image_msg(decode_color(bytes(msg.data)), "rgb8", msg.header))

    taken: dict[str, Callable[[Any], None]] = {
        topics.color: collector.on_color, compressed: decompressed, topics.depth: collector.on_depth,
        topics.info: collector.on_info, topics.tool_pose: collector.on_pose, topics.joint_state: collector.on_joints,
    }  # fmt: skip
    wanted = {names[name.lstrip("/")]: take for name, take in taken.items() if name.lstrip("/") in names}
    color = [name for name in (topics.color, compressed) if name.lstrip("/") in names]
    missing = [name for name in (topics.info, topics.tool_pose) if name.lstrip("/") not in names]
    if missing or not color:
        lacking = ", ".join([*missing, *([] if color else [topics.color])])
        raise MbdError(f"the bag has no {lacking}; it has {', '.join(sorted(names.values()))}: name yours by an option")
    for message, decoded in bag.decoded(list(wanted)):
        wanted[message.topic](decoded)
        if collector.done:
            break
    return collector.count


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 2 for a bag that cannot be used or shows no board."""
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--out", type=Path, required=True, help="new folder for pictures and poses")
    parser.add_argument("--board", default=str(PrintedBoard()), help="as `calibrate` takes it (default %(default)s)")
    parser.add_argument("--mounting", choices=[m.value for m in BoardMounting], default="hand", help="of the board")
    for option, topic in (
        ("color", COLOR), ("depth", DEPTH), ("info", INFO), ("tool-pose", TOOL_POSE), ("joint-state", JOINT_STATE),
    ):  # fmt: skip
        parser.add_argument(f"--{option}", default=topic, help="topic in the bag (default %(default)s)")
    given = parser.parse_args(words)

    def tool() -> int:
        refuse_used(given.out)
        taking = PictureTaking(given.out, board_of(given.board), BoardMounting(given.mounting), MOST)
        count = collect(Bag(given.bag), taking, given, print_line)
        if not count:
            raise MbdError(f"the hand rests before the camera with the board {given.board} nowhere in {given.bag}")
        print_line(f"{count} pictures in {given.out}; next: calibrate solve {given.out} --out FILE")
        return 0

    run_tool("calibration_bag", tool)


def print_line(line: str) -> None:
    """On standard output."""
    sys.stdout.write(f"{line}\n")


if __name__ == "__main__":
    main()
