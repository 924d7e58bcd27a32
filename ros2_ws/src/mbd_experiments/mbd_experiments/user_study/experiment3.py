"""``experiment3 FOLDER...``: when the robot should stop asking: confidence thresholds, assists, autonomy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import HERE

from mbd_experiments.csv_table import write_csv
from mbd_experiments.reproduction.figures import draw_figure10
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.experiment_command import read_arguments, write_report
from mbd_experiments.user_study.predictions import read_predictions, write_predictions
from mbd_experiments.user_study.thresholds import best_thresholds, figure10


def run(cases: Sequence[Case], out: Path, strategies: Sequence[str], executor: Executor = HERE) -> list[Path]:
    """Experiment 3 (paper sec. 7): figures 10 a to d and the best thresholds.

    Args:
        cases: the sessions.
        out: folder for ``predictions.csv``, ``figure10.csv``, ``best_thresholds.csv``, pictures and report.
        strategies: of the mapping, side by side.
        executor: who predicts.

    Returns:
        What was written; files of an earlier run are replaced.
    """
    rows = figure10(read_predictions(write_predictions(cases, out / "predictions.csv", strategies, executor)))
    table = write_csv(out / "figure10.csv", rows)
    best = write_csv(out / "best_thresholds.csv", best_thresholds(rows))
    pictures = draw_figure10(table, out)
    return [table, best, *pictures, write_report(out / "experiment3.md", "Experiment 3", [best], pictures)]


def _tool() -> int:
    return read_arguments("experiment3", __doc__ or "", run)


def main() -> None:
    """Entry point: exit code 0, or 2 when the folders cannot be used."""
    run_tool("experiment3", _tool)
