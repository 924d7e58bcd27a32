"""``repair BAG``: a complete copy of a bag that is cut off or damaged, with all that is intact in it."""

from __future__ import annotations

import shutil
from argparse import ArgumentParser
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console
from rich.markup import escape

from mbd_bag.errors import BagError
from mbd_bag.formats.opening import stored_files
from mbd_bag.formats.packed import SUFFIX
from mbd_bag.formats.sqlite_file import FIRST_BYTES
from mbd_bag.repairing.copying import copy_intact
from mbd_bag.repairing.second_readers import refuse_unreadable
from mbd_bag.repairing.sqlite.copying import copy_rows
from mbd_bag.repairing.stated_topics import StatedTopic, stated_topics
from mbd_bag.repairing.unpacking import unpack_intact
from mbd_bag.session.command_line import bag_parser, note, run_tool
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import read_metadata
from mbd_bag.storage.finishing import finish
from mbd_bag.storage.record_file import refuse_if_written


@dataclass(frozen=True)
class BagParts:
    """What a bag is made of, found without reading it.

    Attributes:
        files: that hold anything, in the order recorded.
        facts: what its metadata.yaml states of the session; {} when that cannot be read.
    """

    files: tuple[Path, ...]
    facts: dict[str, str]


@dataclass(frozen=True)
class RepairedFile:
    """What became of one file: how many messages were kept, and for people what was kept and lost."""

    kept: int
    sentences: tuple[str, ...]


def problems_of(path: Path) -> tuple[str, ...]:
    """What is wrong with a bag, one sentence each, also of one that no tool opens; () for one that is complete."""
    try:
        bag = Bag(path)
        return tuple(problem for problem in bag.check() if problem not in bag.notes)
    except BagError as error:
        return (str(error),)


def parts_of(path: Path) -> BagParts:
    """The files of a bag, whatever state it is in; raises BagError when there is none."""
    if not path.exists():
        raise BagError(f"there is no bag {path}; give the folder a `recorder` wrote, or one of its files")
    if path.is_file():
        return BagParts((path,), {})
    facts: dict[str, str] = {}
    names: list[str] = []
    try:
        metadata = read_metadata(path)
        facts, names = metadata["custom_data"], metadata["relative_file_paths"]
    except BagError:
        pass
    present = stored_files(path)
    listed = [path / name for name in names if path / name in present]
    files = [p for p in [*listed, *(p for p in present if p not in listed)] if p.stat().st_size]
    if not files:
        raise BagError(f"{path} holds no .mcap or .db3 file that is not empty; there is nothing to repair")
    return BagParts(tuple(files), facts)


def repair(path: Path, out: Path) -> tuple[RepairedFile, ...]:
    """Copy what is intact in a bag; the bag itself is only read. Returns what became of each of its files.

    Args:
        path: a bag that is cut off or damaged.
        out: folder of the copy; it must not exist.

    Raises:
        BagError: it exists, the bag is still being written, or nothing in it is intact.
    """
    if out.exists():
        raise BagError(f"{out} exists already and is not overwritten; give another folder with --out")
    parts = parts_of(path)
    for file in parts.files:
        refuse_if_written(file)
    out.mkdir(parents=True)
    copies = [out / f"{out.name}_{number}.mcap" for number in range(len(parts.files))]
    stated = stated_topics(path) if len(parts.files) == 1 else ()
    repaired = tuple(_copied(file, copy, stated) for file, copy in zip(parts.files, copies, strict=True))
    kept = sum(file.kept for file in repaired)
    if not kept:
        shutil.rmtree(out)
        raise BagError(f"no message in {path} is intact: there is nothing that a copy could hold")
    finish(out, copies, parts.facts)
    refuse_unreadable(out, kept)
    return repaired


def _copied(file: Path, copy: Path, stated: tuple[StatedTopic, ...]) -> RepairedFile:
    """Copy what is intact in one file, unpacked as far as that goes."""
    with TemporaryDirectory(prefix="mbd_repair_") as folder:
        source, problem = unpack_intact(file, Path(folder)) if file.name.endswith(SUFFIX) else (file, "")
        with source.open("rb") as stream:
            is_sqlite = stream.read(len(FIRST_BYTES)) == FIRST_BYTES or source.suffix == ".db3"
        copied = copy_rows(source, copy, stated) if is_sqlite else copy_intact(source, copy, stated)
    said = (problem,) if problem else ()
    return RepairedFile(copied.kept, (*said, *copied.sentences(file.name)))


def _parser() -> ArgumentParser:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--out", type=Path, help="folder of the copy (default: <bag>_repaired beside it)")
    return parser


def _tool() -> int:
    arguments = _parser().parse_args()
    console = Console()
    path: Path = arguments.bag.resolve()
    problems = problems_of(path)
    if not problems:
        console.print(f"{escape(str(path))} is complete: there is nothing to repair", highlight=False, soft_wrap=True)
        return 0
    for problem in problems:
        note(problem, console)
    name = path.name.partition(".")[0] if path.is_file() else path.stem
    out: Path = arguments.out or path.with_name(f"{name}_repaired")
    repaired = repair(path, out)
    for sentence in (s for file in repaired for s in file.sentences):
        console.print(escape(sentence), highlight=False, soft_wrap=True)
    text = f"{sum(file.kept for file in repaired)} messages in {out}; {path} is as it was"
    console.print(escape(text), highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when nothing of the bag can be read."""
    run_tool("repair", _tool)
