"""``export BAG… --out DIR``: a study's sessions as tables in CSV (and Parquet)."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import astuple, fields
from importlib import import_module
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import note, open_session, run_tool
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from rich.console import Console

from mbd_study.recompute.reevaluate_command import useful_jobs
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.tables.correspondences import CorrespondenceRow
from mbd_study.tables.datapackage import write_datapackage
from mbd_study.tables.events import EventRow
from mbd_study.tables.forms import FormRow, ScoreRow
from mbd_study.tables.markers import MarkerRow
from mbd_study.tables.steps import StepRow
from mbd_study.tables.table_rows import EstimateRow, GivenAssistRow, SessionRow, SessionTables, session_tables

TABLES: dict[str, type] = {
    "sessions": SessionRow,
    "steps": StepRow,
    "assists": GivenAssistRow,
    "estimates": EstimateRow,
    "correspondences": CorrespondenceRow,
    "events": EventRow,
    "markers": MarkerRow,
    "forms": FormRow,
    "scores": ScoreRow,
}


def write_csv(tables: Iterable[SessionTables], folder: Path) -> dict[str, int]:
    """Write ``sessions.csv``, ``steps.csv``, ... session by session; returns the number of rows of each.

    A value nobody knows is an empty cell; true and false are ``true`` and ``false``.

    Args:
        tables: of the sessions; taken one after the other.
        folder: made when missing.

    Raises:
        BagError: a table is there already; none is overwritten.
    """
    folder.mkdir(parents=True, exist_ok=True)
    counts = dict.fromkeys(TABLES, 0)
    with ExitStack() as undone, ExitStack() as stack:
        writers = {}
        for name, kind in TABLES.items():
            path = folder / f"{name}.csv"
            if path.exists():
                raise BagError(f"{path} exists already and is not overwritten; choose another --out")
            writers[name] = csv.writer(stack.enter_context(path.open("x", newline="", encoding="utf-8")))
            undone.callback(path.unlink)
            writers[name].writerow(field.name for field in fields(kind))
        for session in tables:
            for name, writer in writers.items():
                rows = getattr(session, name)
                counts[name] += len(rows)
                writer.writerows([_cell(value) for value in astuple(row)] for row in rows)
        # A bag that cannot be read leaves no half of the tables, which the next try would find in its place.
        undone.pop_all()
    return counts


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else value


def _arrow() -> list[Any]:
    """The modules of pyarrow; raises BagError when it is not installed."""
    try:
        return [import_module(f"pyarrow{part}") for part in ("", ".csv", ".parquet")]
    except ImportError as error:
        raise BagError("Parquet needs pyarrow (170 MB), which is not installed: pip install pyarrow") from error


def write_parquet(folder: Path) -> None:
    """Write ``<table>.parquet`` beside each CSV table; raises BagError when pyarrow is not installed."""
    arrow, reading, writing = _arrow()
    kinds = {
        "str": arrow.string(),
        "int": arrow.int64(),
        "float": arrow.float64(),
        "bool": arrow.bool_(),
    }
    for name, kind in TABLES.items():
        types = {field.name: kinds[str(field.type).removesuffix(" | None")] for field in fields(kind)}
        options = reading.ConvertOptions(column_types=types, strings_can_be_null=False)
        table = reading.read_csv(folder / f"{name}.csv", convert_options=options)
        writing.write_table(table, folder / f"{name}.parquet")


def read_tables(paths: Sequence[Path], executor: Executor, console: Console) -> Iterator[SessionTables]:
    """The tables of each bag in turn, with a word on what is missing from it.

    Args:
        paths: of the bags.
        executor: that reads them.
        console: for what is missing.

    Raises:
        BagError: a bag cannot be read.
    """
    tables = executor.run_all(_tables_of, [path.absolute() for path in paths])
    for problems, session in tables:
        for problem in problems:
            note(problem, console)
        yield session


def _tables_of(path: Path) -> tuple[tuple[str, ...], SessionTables]:
    """What is missing from a bag, and what it holds."""
    bag, session = open_session(path)
    return session.problems, session_tables(bag, session)


def _tool() -> int:
    parser = CommandParser(prog="export", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="bags, or folders of bags")
    parser.add_argument("--out", type=Path, required=True, help="folder of the tables")
    parser.add_argument("--parquet", action="store_true", help="Parquet too (needs pyarrow)")
    parser.add_argument("--superseded", action="store_true", help="also first tries that were recorded again")
    add_executor_options(parser, "sessions")
    arguments = parser.parse_args()
    console = Console()
    if arguments.parquet:
        # Reported before many bags are read, not after.
        _arrow()
    paths = list(bags_below(arguments.bags, superseded=arguments.superseded))
    executor = executor_of(arguments, useful_jobs(len(paths), RecomputeFrom.ASSISTS))
    counts = write_csv(read_tables(paths, executor, console), arguments.out)
    write_datapackage(arguments.out, TABLES)
    if arguments.parquet:
        write_parquet(arguments.out)
    rows = ", ".join(f"{count} {name}" for name, count in counts.items())
    console.print(f"wrote {rows} to {arguments.out}", highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when a bag cannot be used."""
    run_tool("export", _tool)
