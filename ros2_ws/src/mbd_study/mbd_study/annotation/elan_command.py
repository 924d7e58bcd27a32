"""``elan write|read|agree``: a session as a file of ELAN's, annotations as CSV, Cohen's kappa of two annotators."""

from __future__ import annotations

import csv
from argparse import Namespace
from pathlib import Path

from mbd_bag.session.command_line import note, read_session, run_tool
from mbd_model.command_line.parser import CommandParser
from mbd_model.parameters import nearest
from mbd_model.times import to_seconds
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.annotation.agreement import agreement
from mbd_study.annotation.elan_file import AnnotationError, read_eaf, write_eaf
from mbd_study.annotation.intervals import Interval, by_tier, session_intervals
from mbd_study.tables.events import event_rows


def _write(arguments: Namespace, console: Console) -> None:
    bag, session = read_session(arguments.bag, console)
    duration = to_seconds(bag.end - bag.start)
    intervals = session_intervals(event_rows(bag, session.name), duration)
    taken = [tier for tier in arguments.tier if tier in by_tier(intervals)]
    if taken:
        raise AnnotationError(f"the session has a tier {taken[0]!r} of its own; give --tier another name")
    write_eaf(arguments.out, intervals, arguments.tier)
    tiers = ", ".join((*by_tier(intervals), *arguments.tier))
    console.print(f"wrote {len(intervals)} annotations in tiers {tiers} to {arguments.out}", highlight=False)


def _read(arguments: Namespace, console: Console) -> None:
    rows = [(path.stem, one) for path in arguments.files for one in read_eaf(path)]
    try:
        with arguments.out.open("x", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(("file", "tier", "start_s", "end_s", "label"))
            writer.writerows((name, i.tier, i.start, i.end, i.label) for name, i in rows)
    except FileExistsError as error:
        raise AnnotationError(f"{arguments.out} exists already and is not overwritten; choose another --out") from error
    except OSError as error:
        raise AnnotationError(f"{arguments.out} cannot be written: {error.strerror}; choose another --out") from error
    console.print(f"wrote {len(rows)} annotations of {len(arguments.files)} files to {arguments.out}", highlight=False)


def _tier_of(path: Path, tier: str) -> tuple[tuple[Interval, ...], float]:
    """The intervals of a tier, and where the last annotation of the file ends [s]."""
    intervals = read_eaf(path)
    tiers = by_tier(intervals)
    if tier not in tiers:
        near = nearest(tier, tiers)
        hint = f"did you mean {near!r}?" if near else f"there are {', '.join(tiers) or 'none with annotations'}"
        raise AnnotationError(f"{path} has no annotation in a tier {tier!r}; {hint}")
    return tiers[tier], max(i.end for i in intervals)


def _agree(arguments: Namespace, console: Console) -> None:
    one, end = _tier_of(arguments.one, arguments.tier)
    other, other_end = _tier_of(arguments.other, arguments.other_tier or arguments.tier)
    found = agreement(one, other, max(end, other_end))
    first, second = (sorted({pair[who] for pair in found.seconds}) for who in (0, 1))
    table = Table(box=None, header_style="bold", pad_edge=False, title="seconds: rows the first, columns the second")
    table.add_column("")
    for label in second:
        table.add_column(escape(label), justify="right")
    for label in first:
        table.add_row(escape(label), *(f"{found.seconds.get((label, column), 0.0):.1f}" for column in second))
    console.print(table)
    console.print(
        f"observed agreement {found.observed:.3f}, by chance {found.expected:.3f}, of {max(end, other_end):.1f} s",
        highlight=False,
    )
    if found.kappa is None:
        note("Cohen's kappa is not defined: both gave one and the same label throughout", console)
    else:
        console.print(f"Cohen's kappa {found.kappa:.3f}", highlight=False)


def _tool() -> int:
    parser = CommandParser(prog="elan", description=__doc__)
    words = parser.add_subparsers(dest="word", required=True)
    write = words.add_parser("write", help="a session's events as tiers")
    write.add_argument("bag", type=Path, help="folder that a recorder wrote, or one .mcap file")
    write.add_argument("--out", type=Path, required=True, help="the .eaf file")
    write.add_argument("--tier", action="append", default=[], help="an empty tier to annotate in; as often as needed")
    read = words.add_parser("read", help="annotations as CSV")
    read.add_argument("files", type=Path, nargs="+", help=".eaf files")
    read.add_argument("--out", type=Path, required=True, help="the CSV file")
    agree = words.add_parser("agree", help="Cohen's kappa of two annotators")
    agree.add_argument("one", type=Path, help=".eaf file of one")
    agree.add_argument("other", type=Path, help=".eaf file of the other; may be the same, with another tier")
    agree.add_argument("--tier", required=True, help="to compare")
    agree.add_argument("--other-tier", help="of the other, if it has another name there")
    arguments = parser.parse_args()
    {"write": _write, "read": _read, "agree": _agree}[arguments.word](arguments, Console())
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when a file cannot be used."""
    run_tool("elan", _tool)
