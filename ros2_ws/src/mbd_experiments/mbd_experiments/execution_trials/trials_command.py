"""How often the robot carries a task out rightly when the mapping is right: seeds in the simulated cell, as a table."""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Sequence

from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_model.share_folder import config_folder
from rich.console import Console

from mbd_experiments.execution_trials.trials import NotShown, Trial, run_trials

PRINT = Console(highlight=False, soft_wrap=True)
TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0 when every trial succeeded in at least the wanted share of the seeds."""
    parser = argparse.ArgumentParser(prog="execution_trials", description=__doc__)
    parser.add_argument("--task", choices=(*TASKS, "all"), default="all")
    parser.add_argument("--seeds", type=int, default=10, help="how many, counted from --first (default 10)")
    parser.add_argument("--first", type=int, default=1, help="the first seed (default 1)")
    parser.add_argument("--wanted", type=float, default=0.9, help="share of successes asked for (default 0.9)")
    add_executor_options(parser, "trials")
    arguments = parser.parse_args(words)
    if arguments.seeds < 1 or arguments.first < 0:
        parser.error(f"--seeds {arguments.seeds} --first {arguments.first}: at least one seed, none negative")
    tasks = TASKS if arguments.task == "all" else (arguments.task,)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    trials = run_trials(
        [(task, seed) for task in tasks for seed in seeds],
        executor_of(arguments),
        config_folder("mbd_cell"),
        config_folder("mbd_perception") / "knowledge.yaml",
    )
    reached = True
    for task in tasks:
        right = sum(_success(*trial) for trial in itertools.islice(trials, len(seeds)))
        PRINT.print(f"{task:14} {right} of {len(seeds)} seeds right")
        reached &= right >= arguments.wanted * len(seeds)
    sys.exit(0 if reached else 1)


def _success(trial: Trial | NotShown, seconds: float) -> bool:
    """Print what became of a trial; whether it succeeded."""
    if isinstance(trial, NotShown):
        PRINT.print(f"{trial.task:14} seed {trial.seed:3}  not shown: {trial.reason}")
        return False
    wrong = "; ".join(f"step {p.step + 1} {p.held} onto {p.onto}: {p.why}" for p in trial.places if not p.success)
    done = sum(p.success for p in trial.places)
    PRINT.print(
        f"{trial.task:14} seed {trial.seed:3}  {done}/{len(trial.places)} places right  {trial.seconds:5.0f} s of robot"
        f"  {seconds:4.0f} s here  {trial.ending}{'  | ' + wrong if wrong else ''}"
    )
    return trial.success


if __name__ == "__main__":
    main()
