"""How often the robot carries a task out rightly when the mapping is right: seeds in the simulated cell, as a table."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.layout.scenes import TaskScenes
from mbd_model.errors import MbdError
from mbd_model.share_folder import config_folder
from rich.console import Console

from mbd_experiments.execution_trials.trials import run_trial

PRINT = Console(highlight=False, soft_wrap=True)
TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0 when every trial succeeded in at least the wanted share of the seeds."""
    parser = argparse.ArgumentParser(prog="execution_trials", description=__doc__)
    parser.add_argument("--task", choices=(*TASKS, "all"), default="all")
    parser.add_argument("--seeds", type=int, default=10, help="how many, counted from --first (default 10)")
    parser.add_argument("--first", type=int, default=1, help="the first seed (default 1)")
    parser.add_argument("--wanted", type=float, default=0.9, help="share of successes asked for (default 0.9)")
    arguments = parser.parse_args(words)
    if arguments.seeds < 1 or arguments.first < 0:
        parser.error(f"--seeds {arguments.seeds} --first {arguments.first}: at least one seed, none negative")
    knowledge = config_folder("mbd_perception") / "knowledge.yaml"
    config = config_folder("mbd_cell")
    reached = True
    for task in TASKS if arguments.task == "all" else (arguments.task,):
        reached &= _report(load_scenes(config / f"{task}.yaml"), arguments, knowledge)
    sys.exit(0 if reached else 1)


def _report(scenes: TaskScenes, arguments: argparse.Namespace, knowledge: Path) -> bool:
    """Run and print the trials of one task; whether enough of them succeeded."""
    right = 0
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        started = time.monotonic()
        try:
            trial = run_trial(scenes, seed, knowledge)
        except MbdError as error:
            PRINT.print(f"{scenes.task:14} seed {seed:3}  not shown: {error}")
            continue
        right += trial.success
        wrong = "; ".join(f"step {p.step + 1} {p.held} onto {p.onto}: {p.why}" for p in trial.places if not p.success)
        done = sum(p.success for p in trial.places)
        PRINT.print(
            f"{scenes.task:14} seed {seed:3}  {done}/{len(trial.places)} places right  {trial.seconds:5.0f} s of robot"
            f"  {time.monotonic() - started:4.0f} s here  {trial.said}{'  | ' + wrong if wrong else ''}"
        )
    PRINT.print(f"{scenes.task:14} {right} of {arguments.seeds} seeds right")
    return right >= arguments.wanted * arguments.seeds


if __name__ == "__main__":
    main()
