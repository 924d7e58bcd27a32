"""``analyse TABLES``: the tables a paper prints of a study, and what so few participants can show."""

from __future__ import annotations

import csv
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from mbd_bag.session.command_line import note, run_tool
from mbd_model.command_line.parser import CommandParser
from rich.console import Console

from mbd_study.analysis.analysis_page import analysis_page
from mbd_study.analysis.comparing import (
    OverallRow,
    PairRow,
    SensitivityRow,
    overall_rows,
    pair_rows,
    sensitivity_rows,
)
from mbd_study.analysis.describing import ConditionRow, condition_rows
from mbd_study.analysis.measured import AnalysisError, MeasuredValues, MeasureScale
from mbd_study.analysis.study_table import (
    StudyTable,
    column_of,
    condition_column,
    measured_values,
    read_study,
    usual_measures,
)
from mbd_study.figures.condition_figure import draw_conditions
from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import read_plan

TABLES: dict[str, type] = {
    "descriptives": ConditionRow,
    "tests": OverallRow,
    "pairs": PairRow,
    "sensitivity": SensitivityRow,
}


def _measures(table: StudyTable, arguments: Namespace, by: str, block: str, console: Console) -> list[MeasuredValues]:
    """The measures that were asked for, with a word on those that cannot be compared."""
    scales = dict.fromkeys(arguments.ratings, MeasureScale.LEVELS) | dict.fromkeys(
        arguments.numbers, MeasureScale.NUMBERS
    )
    for name in scales:
        column_of(table, name)
    found = []
    for name in arguments.measures or usual_measures(table):
        one = measured_values(
            table, name, by=by, participant=arguments.participant, block=block, scale=scales.get(name)
        )
        if one is None or len(one.conditions) < 2:
            note(f"{name} is left out: it has values in fewer than two conditions", console)
        else:
            found.append(one)
    if not found:
        raise AnalysisError(f"no measure has values in two conditions of column {by!r}; nothing can be compared")
    return found


def _block(table: StudyTable, given: str | None, by: str) -> str:
    """The column of the blocks; "" for none."""
    if given == "none":
        return ""
    if given:
        return column_of(table, given)
    varies = len({row.get("task", "") for row in table.rows} - {""}) > 1
    return "task" if varies and by != "task" else ""


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else value


def write_tables(folder: Path, tables: dict[str, Sequence[Any]]) -> None:
    """Write each table as CSV; raises AnalysisError when one is there already."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in tables.items():
        path = folder / f"{name}.csv"
        if path.exists():
            raise AnalysisError(f"{path} exists already and is not overwritten; choose another --out")
        with path.open("x", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(f.name for f in fields(TABLES[name]))
            writer.writerows([_cell(v) for v in astuple(row)] for row in rows)


def _arguments() -> Namespace:
    parser = CommandParser(prog="analyse", description=__doc__)
    parser.add_argument("tables", type=Path, help="folder that `export` wrote, or a CSV file with a row a session")
    parser.add_argument("--plan", type=Path, help="the study's plan.yaml: it knows each session's condition")
    parser.add_argument("--by", metavar="COLUMN", help="of the conditions (default: condition)")
    parser.add_argument("--measures", nargs="+", metavar="COLUMN", help="to compare (default: what export knows)")
    parser.add_argument("--participant", default="participant", metavar="COLUMN", help="of the participants")
    parser.add_argument("--blocks", metavar="COLUMN", help="that also makes a difference (default: task; none: none)")
    parser.add_argument("--ratings", nargs="+", default=[], metavar="COLUMN", help="levels, compared by rank")
    parser.add_argument("--numbers", nargs="+", default=[], metavar="COLUMN", help="no levels, though they look it")
    parser.add_argument("--out", type=Path, help="folder for the tables, a page and figures; made when missing")
    return parser.parse_args()


def _tool() -> int:
    arguments, console = _arguments(), Console()
    if arguments.out is not None and (arguments.out / "analysis.md").exists():
        # Reported before anything is computed, not after.
        raise AnalysisError(f"{arguments.out} holds an analysis already, not overwritten; choose another --out")
    planned = None
    if arguments.plan is not None:
        planned = {p.session: p.condition for p in planned_sessions(read_plan(arguments.plan))}
    table = read_study(arguments.tables, planned)
    for sentence in table.left_out:
        note(sentence, console)
    by = condition_column(table, [arguments.by, "condition" if planned is not None else None])
    column_of(table, arguments.participant)
    block = _block(table, arguments.blocks, by)
    measures = _measures(table, arguments, by, block, console)
    tables: dict[str, Sequence[Any]] = {
        "descriptives": [row for m in measures for row in condition_rows(m)],
        "tests": overall_rows(measures),
        "pairs": [row for m in measures for row in pair_rows(m)],
        "sensitivity": [row for m in measures for row in sensitivity_rows(m)],
    }
    page = analysis_page(tables, measures, table, by=by, block=block)
    console.print(page, highlight=False, markup=False, soft_wrap=True)
    if arguments.out is not None:
        write_tables(arguments.out, tables)
        (arguments.out / "analysis.md").write_text(page + "\n", encoding="utf-8")
        for measured in measures:
            draw_conditions(measured, arguments.out / f"{measured.name}.png")
        console.print(f"wrote {', '.join(tables)} and a figure a measure to {arguments.out}", highlight=False)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the table cannot be analysed."""
    run_tool("analyse", _tool)
