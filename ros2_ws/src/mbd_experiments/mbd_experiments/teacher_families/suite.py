"""``mapping_suite``: every family of teachers, both strategies, family by family, both halves.

``choose`` families were used to choose priors, errors and defaults; ``report`` families for no choice at all.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from mbd_mapping.config import MappingConfig
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from rich.console import Console
from rich.table import Table

from mbd_experiments.csv_table import CsvRow, write_csv
from mbd_experiments.teacher_families.families import FAMILIES, Family, Half
from mbd_experiments.teacher_families.lesson import Lesson
from mbd_experiments.teacher_families.measures import Figures, figures
from mbd_experiments.teacher_families.playing import finish, listen

STRATEGY_NAMES = ("mbd", "evidence")
COLUMNS = (
    "solved after 0..4",
    "ECE",
    "right where >= 0.9",
    "how often",
    "best guess, all told",
    "asked",
    "ends as meant",
)


def lessons_of(family: Family, seed: int, count: int) -> list[Lesson]:
    """``count`` lessons of a family; the same seed gives the same ones."""
    name = zlib.crc32(family.name.encode())
    return [family.make(np.random.default_rng([seed, name, number])) for number in range(count)]


def judge(family: Family, lessons: Sequence[Lesson], config: MappingConfig) -> Figures:
    """The figures of a family under one configuration."""
    states = [listen(lesson, config, family.counts) for lesson in lessons]
    return figures(states, [finish(lesson, config) for lesson in lessons])


def row_of(family: Family, strategy: str, found: Figures) -> CsvRow:
    """As a row of the table."""
    return {
        "half": str(family.half),
        "family": family.name,
        "strategy": strategy,
        "solved after 0..4": " ".join(f"{s:.2f}" for s in found.solved),
        "ECE": f"{found.calibration_error:.3f}",
        "right where >= 0.9": f"{found.sure_right:.2f}",
        "how often": f"{found.sure_share:.2f}",
        "best guess, all told": f"{found.guess_right:.2f}",
        "asked": f"{found.questions:.2f}",
        "ends as meant": f"{found.as_meant:.3f}",
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; returns 0."""
    parser = CommandParser(prog="mapping_suite", description=__doc__)
    parser.add_argument("--lessons", type=at_least_one, default=200, help="of each family")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--half", choices=[str(h) for h in Half], help="only this half")
    parser.add_argument("--family", action="append", help="only this family")
    parser.add_argument("--strategy", action="append", choices=STRATEGY_NAMES, help="only this; default: both")
    parser.add_argument("--csv", type=Path, default=Path("mapping_suite.csv"), help="where the table goes")
    options = parser.parse_args(arguments)
    base = MappingConfig()
    console = Console(width=160)
    rows: list[CsvRow] = []
    for half in Half:
        table = Table("family", "strategy", *COLUMNS, title=f"half '{half}', {options.lessons} lessons of each family")
        for family in FAMILIES:
            if family.half != half or (options.half and options.half != half):
                continue
            if options.family and family.name not in options.family:
                continue
            # Large scenes cost much more each, and vary less.
            count = options.lessons if family.counts is None else options.lessons // 5
            lessons = lessons_of(family, options.seed, count)
            for strategy in options.strategy or STRATEGY_NAMES:
                row = row_of(family, strategy, judge(family, lessons, replace(base, strategy=strategy)))
                rows.append(row)
                table.add_row(family.name, strategy, *(str(row[c]) for c in COLUMNS))
        if table.row_count:
            console.print(table)
    if rows:
        console.print(f"table in {write_csv(options.csv, rows)}", highlight=False)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
