"""`ros2 run mbd_experiments experiment1`: experiment 1 complete, as CSV and figures 4-6.

All objects are simulated. Standard: 5, 6 and 7 objects, 10 problems each. --larger: 8 to 10 objects, 100 problems each.
On every core of the machine, or on a cluster.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from mbd_model.folders import make_folder
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from mbd_experiments.simulated_problems.experiment1 import Judged, SolvedShare, run_problem
from mbd_experiments.simulated_problems.experiment1_figures import draw
from mbd_experiments.simulated_problems.experiment1_tables import (
    Calibration,
    Share,
    calibrations,
    read_shares,
    shares,
    write_table,
)

STANDARD = ((5, 6, 7), 10)
LARGER = ((8, 9, 10), 100)


def compute(
    sizes: Sequence[int], problems: int, *, seed: int, runs: int, executor: Executor, console: Console
) -> tuple[list[SolvedShare], list[Judged]]:
    """Every problem by size and number; the result does not depend on who computes it."""
    # The large ones first, so that none is begun last that takes longest.
    work = [(size, number) for size in sorted(sizes, reverse=True) for number in range(problems)]
    columns = ("experiment 1", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        results = executor.run_all(partial(run_problem, seed, runs), work, _named)
        done = dict(zip(work, bar.track(results, total=len(work)), strict=True))
    ordered = [done[key] for key in sorted(done)]
    return [o for outcomes, _ in ordered for o in outcomes], [j for _, judged in ordered for j in judged]


def _named(which: tuple[int, int]) -> str:
    size, number = which
    return f"problem {number} of {size} objects"


def share_table(rows: Sequence[Share]) -> Table:
    """Share solved within k assists, sizes and methods down, k across."""
    most = max(row.assists for row in rows)
    table = Table(title="solved after ≤ k assists [%]: mean ± std over problems")
    table.add_column("n")
    table.add_column("method", no_wrap=True)
    for k in range(most + 1):
        table.add_column(f"k={k}", justify="right", no_wrap=True)
    for size, method in dict.fromkeys((row.size, row.method) for row in rows):
        own = {row.assists: row for row in rows if (row.size, row.method) == (size, method)}
        cells = [
            f"{100 * own[k].solved_within:.0f} ±{100 * own[k].spread:.0f}" if k in own else "" for k in range(most + 1)
        ]
        table.add_row(str(size), method, *cells)
    return table


def findings(rows: Sequence[Share], calibrated: Sequence[Calibration]) -> list[str]:
    """What issue and paper ask of the figures, a sentence each."""
    lines = []
    for size in sorted({row.size for row in rows}):
        two = {row.method: row.solved_within for row in rows if row.size == size and row.assists == 2}
        lines.append(
            f"n = {size}: after 2 assists evidence solves {two['evidence'] / two['mbd']:.2f} times what mbd does"
        )
    for row in calibrated:
        if row.assists == -1 and row.method == "evidence":
            lines.append(f"n = {row.size}, {row.scenario}: expected calibration error of evidence {row.error:.3f}")
        if row.assists == row.size - 1 and row.scenario.startswith("two"):
            lines.append(
                f"n = {row.size}, all {row.assists} assists, {row.scenario}: {row.method} {row.solved:.2f} solved"
            )
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; 0 when it worked."""
    parser = CommandParser(prog="experiment1", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="same seed, same figures")
    parser.add_argument("--larger", action="store_true", help="8 to 10 objects, 100 problems each")
    parser.add_argument("--sizes", type=int, nargs="+", help="numbers of objects, at least 3")
    parser.add_argument("--problems", type=at_least_one, help="problems of each size")
    parser.add_argument("--runs", type=int, default=2, help="runs with wrong assists of each problem and truth")
    add_executor_options(parser, "problems")
    parser.add_argument("--out", type=Path, default=Path("out/experiment1"), help="folder of tables and figures")
    options = parser.parse_args(arguments)
    standard_sizes, standard_problems = LARGER if options.larger else STANDARD
    sizes, problems = options.sizes or standard_sizes, options.problems or standard_problems
    if min(sizes) < 3 or problems < 1 or options.runs < 0:
        parser.error("--sizes must be 3 or more, --problems 1 or more, --runs 0 or more")
    run(options.out, executor_of(options), sizes=sizes, problems=problems, seed=options.seed, runs=options.runs)
    return 0


def run(
    out: Path,
    executor: Executor,
    *,
    sizes: Sequence[int] = STANDARD[0],
    problems: int = STANDARD[1],
    seed: int = 1,
    runs: int = 2,
) -> None:
    """Compute experiment 1, write its tables and figures, and print what they show.

    Args:
        out: folder of tables and figures.
        executor: who computes.
        sizes: numbers of objects, 3 or more each.
        problems: of each size.
        seed: same seed, same figures.
        runs: with wrong assists of each problem and truth.
    """
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 110)
    outcomes, judged = compute(sizes, problems, seed=seed, runs=runs, executor=executor, console=console)
    make_folder(out)
    write_table(outcomes, out / "outcomes.csv")
    write_table(shares(outcomes), out / "shares.csv")
    calibrated = calibrations(judged)
    write_table(calibrated, out / "calibration.csv")
    rows = read_shares(out / "shares.csv")
    for size in sizes:
        draw(rows, size, out / f"solved_{size}_objects.png")
    console.print(share_table(rows))
    for line in findings(rows, calibrated):
        console.print(line)
    console.print(f"simulated objects, seed {seed}; tables and figures in {out}")


if __name__ == "__main__":
    raise SystemExit(main())
