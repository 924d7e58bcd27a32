"""``experiment2 FOLDER...``: what the tasks were, how consistent the participants, how many assists they needed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import HERE

from mbd_experiments.csv_table import write_csv
from mbd_experiments.reproduction.figures import draw_figure9
from mbd_experiments.user_study.assists_needed import figure9
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.experiment_command import read_arguments, write_report
from mbd_experiments.user_study.predictions import read_predictions, write_predictions
from mbd_experiments.user_study.study_tables import table4, table5


def run(cases: Sequence[Case], out: Path, strategies: Sequence[str], executor: Executor = HERE) -> list[Path]:
    """Experiment 2 (paper sec. 6): tables 4 and 5, figure 9.

    Args:
        cases: the sessions.
        out: folder for ``predictions.csv``, ``table4.csv``, ``table5.csv``, ``figure9.csv``, pictures and report.
        strategies: of the mapping, side by side.
        executor: who predicts.

    Returns:
        What was written; files of an earlier run are replaced.
    """
    predictions = read_predictions(write_predictions(cases, out / "predictions.csv", strategies, executor))
    tables = [
        write_csv(out / "table4.csv", table4(cases)),
        write_csv(out / "table5.csv", table5(cases, predictions)),
        write_csv(out / "figure9.csv", figure9(predictions)),
    ]
    pictures = draw_figure9(tables[2], out)
    return [*tables, *pictures, write_report(out / "experiment2.md", "Experiment 2", tables, pictures)]


def _tool() -> int:
    return read_arguments("experiment2", __doc__ or "", run)


def main() -> None:
    """Entry point: exit code 0, or 2 when the folders cannot be used."""
    run_tool("experiment2", _tool)
