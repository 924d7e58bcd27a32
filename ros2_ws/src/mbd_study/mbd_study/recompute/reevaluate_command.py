"""``reevaluate BAG…``: compute sessions again, offline, from a recorded stage, and report every difference."""

from __future__ import annotations

import time
from argparse import ArgumentParser
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

from mbd_bag.session.command_line import BAD_BAG, run_tool
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from rich.console import Console
from rich.markup import escape
from rich.progress import track

from mbd_study.recompute.given_parameters import facts_of_files
from mbd_study.recompute.replay_table import AGREES, DIFFERS
from mbd_study.recompute.session_check import CheckSummary, check_bag
from mbd_study.recompute.stages import RecomputeFrom


def useful_jobs(number: int, stage: RecomputeFrom) -> int:
    """How many processes are worth the second or two each takes to start, for so many bags."""
    bags_a_process = 4 if stage is RecomputeFrom.CLOUDS else 40
    return max(1, number // bags_a_process)


def check_bags(
    paths: Iterable[Path], stage: RecomputeFrom, executor: Executor, given: Mapping[str, str] | None = None
) -> Iterator[CheckSummary]:
    """Each bag's summary, in the order given; of a bag only its summary comes back.

    Args:
        paths: of bags; taken as they are needed.
        stage: to compute from.
        executor: who computes.
        given: facts in place of those the bags state.
    """
    # Workers may be at home in other folders.
    named = ((path, path.absolute()) for path in paths)
    return executor.run_all(partial(_check, stage, dict(given or {})), named, lambda item: str(item[0]))


def _check(stage: RecomputeFrom, given: Mapping[str, str], named: tuple[Path, Path]) -> CheckSummary:
    """The summary of the bag as it was named, found by its absolute path."""
    return replace(check_bag(named[1], stage, given), path=named[0])


def _line(summary: CheckSummary) -> str:
    if summary.failure:
        return f"[red]unusable[/]  {escape(str(summary.path))}: {escape(summary.failure)}"
    verdict = "[green]agrees[/]  " if summary.agrees else "[red]differs[/] "
    speed = summary.recorded_seconds / summary.seconds if summary.seconds else 0.0
    return (
        f"{verdict}  {summary.agreeing} of {summary.estimates} estimates, {summary.seconds:.2f} s "
        f"({speed:.0f} x real time)  {escape(str(summary.path))}"
    )


def _parser() -> ArgumentParser:
    parser = CommandParser(prog="reevaluate", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="bags, or folders of bags")
    parser.add_argument(
        "--from",
        dest="stage",
        type=RecomputeFrom,
        choices=list(RecomputeFrom),
        default=RecomputeFrom.ASSISTS,
        help="stage (default assists)",
    )
    parser.add_argument(
        "--parameters",
        type=Path,
        nargs="+",
        default=[],
        metavar="FILE",
        help="parameter files of the session's nodes, for what a bag does not state (where the camera stood, ...); "
        "'defaults' stands for the default of all others",
    )
    add_executor_options(parser, "sessions")
    parser.add_argument("--superseded", action="store_true", help="also first tries that were recorded again")
    return parser


def _tool() -> int:
    arguments = _parser().parse_args()
    console, errors = Console(), Console(stderr=True)
    paths = list(bags_below(arguments.bags, superseded=arguments.superseded))
    begun = time.perf_counter()
    executor = executor_of(arguments, useful_jobs(len(paths), arguments.stage))
    results = check_bags(paths, arguments.stage, executor, facts_of_files(arguments.parameters))
    totals = {"agrees": 0, "differs": 0, "unusable": 0}
    for summary in track(results, "computing", len(paths), console=console, disable=len(paths) < 8, transient=True):
        totals["unusable" if summary.failure else "agrees" if summary.agrees else "differs"] += 1
        (errors if summary.failure else console).print(_line(summary), highlight=False, soft_wrap=True)
        for line in summary.lines:
            console.print(f"    {escape(line)}", highlight=False, soft_wrap=True)
    console.print(
        f"[bold]{len(paths)} sessions from {arguments.stage}: {totals['agrees']} agree, {totals['differs']} differ, "
        f"{totals['unusable']} cannot be used[/]; {time.perf_counter() - begun:.1f} s, {executor}",
        highlight=False,
    )
    return BAD_BAG if totals["unusable"] else DIFFERS if totals["differs"] else AGREES


def main() -> None:
    """Entry point: exit code 0 when all agree, 1 when some differ, 2 when a bag cannot be used."""
    run_tool("reevaluate", _tool)
