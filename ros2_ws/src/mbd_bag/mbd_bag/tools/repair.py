"""``repair BAG``: a complete copy of a bag whose recorder was killed, so that rosbag2, rosbags and Foxglove take it."""

from __future__ import annotations

import shutil
from argparse import ArgumentParser
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import bag_parser, run_tool
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import refuse_if_written
from mbd_bag.storage.finishing import finish


def repair(bag: Bag, out: Path) -> Path:
    """Copy a bag and finish the copy; the bag itself is only read. Returns the copy.

    Args:
        bag: whose recorder was killed, or that is damaged.
        out: folder of the copy; it must not exist.

    Raises:
        BagError: it exists, or the bag is still being written.
    """
    if out.exists():
        raise BagError(f"{out} exists already and is not overwritten; give another folder with --out")
    for file in bag.files:
        refuse_if_written(file.path)
    out.mkdir(parents=True)
    files = [out / f"{out.name}_{number}.mcap" for number in range(len(bag.files))]
    for file, copied in zip(bag.files, files, strict=True):
        shutil.copyfile(file.path, copied)
    finish(out, files, bag.facts, damaged=True)
    return out


def _parser() -> ArgumentParser:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--out", type=Path, help="folder of the copy (default: <bag>_repaired beside it)")
    return parser


def _tool() -> int:
    arguments = _parser().parse_args()
    console = Console()
    path: Path = arguments.bag.resolve()
    bag = Bag(path)
    if not bag.problems:
        console.print(f"{escape(str(path))} is complete: there is nothing to repair", highlight=False, soft_wrap=True)
        return 0
    for problem in bag.problems:
        console.print(f"[yellow]note:[/] {escape(problem)}", highlight=False, soft_wrap=True)
    out = repair(bag, arguments.out or path.with_name(f"{path.stem}_repaired"))
    text = f"{Bag(out).message_count} messages in {out}; {path} is as it was"
    console.print(escape(text), highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when nothing of the bag can be read."""
    run_tool("repair", _tool)
