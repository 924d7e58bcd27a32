"""``bids BAG… --out FOLDER``: sessions in the Brain Imaging Data Structure, valid by its own validator."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.session.command_line import note, run_tool
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.parallel.options import add_executor_options, executor_of
from rich.console import Console

from mbd_study.bids.bids_folder import BidsError, DatasetFacts, write_bids
from mbd_study.recompute.reevaluate_command import useful_jobs
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.tables.export import read_tables


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("mbd_study")
    except PackageNotFoundError:
        return "unknown"


def _tool() -> int:
    parser = CommandParser(prog="bids", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="bags, or folders of bags; best what `share` wrote")
    parser.add_argument("--out", type=Path, required=True, help="folder of the data set; it must not exist")
    parser.add_argument("--name", default="Mapping by Demonstration", help="of the data set")
    parser.add_argument("--author", action="append", default=[], help="as it shall be cited; as often as needed")
    parser.add_argument("--licence", default="", help="of the data: CC0, PDDL, CC-BY-4.0, ...")
    kept = "keep what was noted, or written in forms; it may name a person"
    parser.add_argument("--notes", action="store_true", help=kept)
    add_executor_options(parser, "sessions")
    arguments = parser.parse_args()
    console = Console()
    if arguments.out.exists():
        # Reported before many bags are read, not after.
        raise BidsError(f"{arguments.out} exists already and is not overwritten; choose another --out")
    paths = list(bags_below(arguments.bags))
    executor = executor_of(arguments, useful_jobs(len(paths), RecomputeFrom.ASSISTS))
    sessions = list(read_tables(paths, executor, console))
    facts = DatasetFacts(arguments.name, tuple(arguments.author), arguments.licence, arguments.notes)
    write_bids(arguments.out, sessions, facts, _version())
    people = len({s.sessions[0].participant or s.sessions[0].session for s in sessions})
    words = f"wrote {len(sessions)} sessions of {people} participants to {arguments.out}"
    console.print(words, highlight=False, soft_wrap=True)
    for missing, option in ((not facts.licence, "--licence"), (not facts.authors, "--author")):
        if missing:
            note(f"the data set states no {option[2:]}; give {option} before it is published", console)
    written = any(row.kind == "text" and row.answered for s in sessions for row in s.forms)
    if not facts.notes and (written or any(s.sessions[0].notes for s in sessions)):
        note("the text of notes, and what was written in forms, is left out (--notes keeps it)", console)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when a bag cannot be used."""
    run_tool("bids", _tool)
