"""``mutation_trials BAG``: change copies of a bag as accident and malice would, read each, and print how that ends."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from rich.console import Console
from rich.progress import track
from rich.table import Table

from mbd_bag.repairing.reading_trials import ReadingEnd, ReadingTrial, reading_trials
from mbd_bag.session.command_line import run_tool

_FAULTS = (ReadingEnd.SILENT, ReadingEnd.TRACEBACK, ReadingEnd.KILLED)
_LONGEST, _MOST = 10.0, 512.0  # [s], [MB]


def _is_fault(trial: ReadingTrial) -> bool:
    return trial.end in _FAULTS or trial.seconds > _LONGEST or trial.megabytes > _MOST


def _tool() -> int:
    parser = CommandParser(prog="mutation_trials", description=__doc__)
    parser.add_argument("bag", type=Path, help="an intact bag of one MCAP file")
    parser.add_argument("--number", type=at_least_one, default=2600, help="of changed copies (default 2600)")
    parser.add_argument("--seed", type=int, default=1, help="of the changes (default 1)")
    arguments = parser.parse_args()
    console = Console()
    with TemporaryDirectory(prefix="mbd_mutation_trials_") as folder:
        trials = reading_trials(arguments.bag, arguments.number, arguments.seed, Path(folder))
        done = list(track(trials, "reading", arguments.number, console=console, transient=True))
    table = Table(box=None, header_style="bold", pad_edge=False)
    for column in ("changed by", *(end.value for end in ReadingEnd), "longest [s]", "most [MB]"):
        table.add_column(column.replace("[", r"\["), justify="left" if column == "changed by" else "right")
    for name in sorted({t.mutation for t in done}):
        of_kind = [t for t in done if t.mutation == name]
        ends = Counter(t.end for t in of_kind)
        worst = max(t.seconds for t in of_kind), max(t.megabytes for t in of_kind)
        table.add_row(name, *(str(ends[end]) for end in ReadingEnd), f"{worst[0]:.1f}", f"{worst[1]:.0f}")
    console.print(table)
    faults = [t for t in done if _is_fault(t)]
    for trial in faults[:20]:
        text = f"{trial.mutation}: {trial.end}, {trial.seconds:.1f} s, {trial.megabytes:.0f} MB: {trial.words}"
        console.print(text, highlight=False, soft_wrap=True, markup=False)
    console.print(f"{len(done)} changed bags (seed {arguments.seed}), {len(faults)} answered badly", highlight=False)
    return 1 if faults else 0


def main() -> None:
    """Entry point: exit code 0, 1 when a bag was answered badly."""
    run_tool("mutation_trials", _tool)
