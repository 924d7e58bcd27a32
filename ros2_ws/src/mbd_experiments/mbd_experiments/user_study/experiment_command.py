"""What the experiments' commands share: folders in, files out, and a page with their tables and figures."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path

from mbd_model.command_line.parser import CommandParser
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_study.recompute.reevaluate_command import useful_jobs
from mbd_study.recompute.stages import RecomputeFrom
from rich.console import Console
from rich.markup import escape

from mbd_experiments.csv_table import markdown, read_csv
from mbd_experiments.reproduction.captions import TITLES, caption, origins_in
from mbd_experiments.user_study.cases import Case, read_cases, sessions_in
from mbd_experiments.user_study.predictions import STRATEGY_NAMES

Experiment = Callable[[Sequence[Case], Path, Sequence[str], Executor], list[Path]]


def read_arguments(name: str, description: str, run: Experiment) -> int:
    """The command line of one experiment; raises BagError when its folders cannot be used."""
    parser = CommandParser(prog=name, description=description)
    parser.add_argument(
        "folders", type=Path, nargs="+", help="the public study folder, a simulated study, or any folder of bags"
    )
    parser.add_argument("--out", type=Path, default=Path(name), help="folder to write into")
    parser.add_argument("--strategy", action="append", choices=STRATEGY_NAMES, help="only this; default: both")
    add_executor_options(parser, "sessions")
    arguments = parser.parse_args()
    console, executor = Console(), session_executor(arguments, arguments.folders)
    cases = read_and_report(arguments.folders, executor, console)
    for path in run(cases, arguments.out, arguments.strategy or STRATEGY_NAMES, executor):
        console.print(str(path), highlight=False, soft_wrap=True)
    return 0


def session_executor(arguments: Namespace, folders: Sequence[Path]) -> Executor:
    """Who reads the folders' sessions and predicts them: as many processes as are worth it for so many."""
    return executor_of(arguments, useful_jobs(sessions_in(folders), RecomputeFrom.ASSISTS))


def read_and_report(folders: Sequence[Path], executor: Executor, console: Console) -> tuple[Case, ...]:
    """The sessions of the folders; prints how many there are and which cannot be used."""
    cases, left_out = read_cases(folders, executor)
    for entry in left_out:
        text = f"[yellow]left out:[/] {escape(str(entry.path))}: {escape(entry.reason)}"
        console.print(text, highlight=False, soft_wrap=True)
    for origin in dict.fromkeys(c.origin for c in cases):
        count = sum(c.origin is origin for c in cases)
        console.print(f"{count} sessions of {origin.words}", highlight=False)
    return cases


def write_report(path: Path, title: str, tables: Sequence[Path], pictures: Sequence[Path]) -> Path:
    """A Markdown page of tables (from their files) and pictures, each with its caption; returns its path."""
    parts = [f"# {title}\n"]
    for table in tables:
        if table.stem in TITLES and not table.stem.startswith("figure"):
            rows = read_csv(table)
            for origin in origins_in(rows):
                own = [r for r in rows if r["origin"] == origin]
                parts += [caption(table.stem, origin, own) + "\n", markdown(own)]
    parts += [f"![{p.stem.replace('_', ', ')} data]({p.name})\n" for p in pictures]
    path.write_text("\n".join(parts), encoding="utf-8")
    return path
