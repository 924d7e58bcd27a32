"""``reevaluate BAG…``: compute sessions again, offline, from a recorded stage, and report every difference."""

from __future__ import annotations

import os
import time
from argparse import ArgumentParser
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from mbd_bag.session.command_line import BAD_BAG, run_tool
from mbd_bag.storage.bag_paths import bags_below
from rich.console import Console
from rich.markup import escape
from rich.progress import track

from mbd_study.recompute.replay_table import AGREES, DIFFERS
from mbd_study.recompute.session_check import CheckSummary, check_bag
from mbd_study.recompute.stages import RecomputeFrom

# Bags in work or waiting per process: enough to keep all busy, however many bags there are.
_AHEAD = 3


def useful_jobs(number: int, stage: RecomputeFrom, jobs: int) -> int:
    """How many of ``jobs`` processes are worth the second or two each takes to start, for so many bags."""
    bags_a_process = 4 if stage is RecomputeFrom.CLOUDS else 40
    return max(1, min(jobs, number // bags_a_process))


def check_bags(paths: Iterable[Path], stage: RecomputeFrom, jobs: int) -> Iterator[CheckSummary]:
    """Each bag's summary, in the order given, computed by as many processes.

    Memory is bounded: of a bag only its summary comes back, and paths are taken as they are needed.

    Args:
        paths: of bags.
        stage: to compute from.
        jobs: processes; 1 computes in this one.
    """
    if jobs <= 1:
        yield from (check_bag(path, stage) for path in paths)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        running: deque[Future[CheckSummary]] = deque()
        for path in paths:
            running.append(pool.submit(check_bag, path, stage))
            if len(running) >= _AHEAD * jobs:
                yield running.popleft().result()
        while running:
            yield running.popleft().result()


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
    parser = ArgumentParser(prog="reevaluate", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="bags, or folders of bags")
    parser.add_argument(
        "--from",
        dest="stage",
        type=RecomputeFrom,
        choices=list(RecomputeFrom),
        default=RecomputeFrom.ASSISTS,
        help="stage (default assists)",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")
    parser.add_argument("--superseded", action="store_true", help="also first tries that were recorded anew")
    return parser


def _tool() -> int:
    arguments = _parser().parse_args()
    console, errors = Console(), Console(stderr=True)
    paths = list(bags_below(arguments.bags, superseded=arguments.superseded))
    begun = time.perf_counter()
    jobs = useful_jobs(len(paths), arguments.stage, arguments.jobs)
    results = check_bags(paths, arguments.stage, jobs)
    totals = {"agrees": 0, "differs": 0, "unusable": 0}
    for summary in track(results, "computing", len(paths), console=console, disable=len(paths) < 8, transient=True):
        totals["unusable" if summary.failure else "agrees" if summary.agrees else "differs"] += 1
        (errors if summary.failure else console).print(_line(summary), highlight=False, soft_wrap=True)
        for line in summary.lines:
            console.print(f"    {escape(line)}", highlight=False, soft_wrap=True)
    console.print(
        f"[bold]{len(paths)} sessions from {arguments.stage}: {totals['agrees']} agree, {totals['differs']} differ, "
        f"{totals['unusable']} cannot be used[/]; {time.perf_counter() - begun:.1f} s, {jobs} processes",
        highlight=False,
    )
    return BAD_BAG if totals["unusable"] else DIFFERS if totals["differs"] else AGREES


def main() -> None:
    """Entry point: exit code 0 when all agree, 1 when some differ, 2 when a bag cannot be used."""
    run_tool("reevaluate", _tool)
