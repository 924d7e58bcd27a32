"""Tables of experiment 1: shares solved with their spread over problems, errors and calibration; CSV in and out."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from mbd_model.estimate import Feature

from mbd_experiments.simulated_problems.experiment1 import (
    Judged,
    SolvedShare,
    calibration_error,
    pruning_baseline,
    random_baseline,
)

NAMES = tuple(Feature)


@dataclass(frozen=True)
class Share:
    """Share solved by one method at one size after k assists: what figures 4-6 draw.

    Attributes:
        size, method, assists: which; methods are the strategies, "pruning" and "random".
        solved_at: mean share solved after exactly k assists; NaN for the baselines.
        solved_within, spread: mean and standard deviation, over problems, of the share solved after <= k assists.
    """

    size: int
    method: str
    assists: int
    solved_at: float
    solved_within: float
    spread: float


@dataclass(frozen=True)
class Calibration:
    """How well a strategy's confidence is the share of right mappings.

    Attributes:
        method, scenario, size, assists: which; assists -1 is all together.
        count: inferences.
        confidence, right, solved: means; right counts mappings as good as the teacher's, solved the teacher's only.
        error: expected calibration error of confidence against right, ten bins.
    """

    method: str
    scenario: str
    size: int
    assists: int
    count: int
    confidence: float
    right: float
    solved: float
    error: float


def shares(outcomes: Iterable[SolvedShare]) -> list[Share]:
    """Mean over truths, then mean and standard deviation over problems; baselines as expected by chance."""
    by_state: dict[tuple[int, str, int], dict[int, list[SolvedShare]]] = defaultdict(lambda: defaultdict(list))
    for outcome in outcomes:
        by_state[outcome.size, outcome.strategy, outcome.assists][outcome.problem].append(outcome)
    table = []
    for (size, strategy, assists), problems in by_state.items():
        within = [np.mean([o.solved_within for o in group]) for group in problems.values()]
        at = [np.mean([o.solved_at for o in group]) for group in problems.values()]
        table.append(Share(size, strategy, assists, float(np.mean(at)), float(np.mean(within)), float(np.std(within))))
    for size, assists in sorted({(size, assists) for size, _, assists in by_state}):
        table.append(Share(size, "pruning", assists, float("nan"), pruning_baseline(size, assists), 0.0))
        table.append(Share(size, "random", assists, float("nan"), random_baseline(size, assists), 0.0))
    return sorted(table, key=lambda row: (row.size, row.method, row.assists))


def calibrations(judged: Iterable[Judged]) -> list[Calibration]:
    """By strategy, scenario, size and number of assists, and all numbers of assists together."""
    groups: dict[tuple[str, str, int, int], list[Judged]] = defaultdict(list)
    for one in judged:
        groups[one.strategy, one.scenario, one.size, one.assists].append(one)
        groups[one.strategy, one.scenario, one.size, -1].append(one)
    table = []
    for (strategy, scenario, size, assists), group in sorted(groups.items()):
        weight = np.array([j.weight for j in group])
        confidence, right, solved = (
            float(np.average([float(getattr(j, name)) for j in group], weights=weight))
            for name in ("confidence", "right", "solved")
        )
        error = calibration_error(group)
        table.append(Calibration(strategy, scenario, size, assists, len(group), confidence, right, solved, error))
    return table


def write_table(rows: Sequence[SolvedShare] | Sequence[Share] | Sequence[Calibration], path: Path) -> None:
    """One row a line, the fields' names first."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([field.name for field in fields(rows[0])])
        for row in rows:
            writer.writerow([_text(getattr(row, field.name)) for field in fields(row)])


def read_shares(path: Path) -> list[Share]:
    """What ``write_table`` wrote: the figures draw only this."""
    with path.open(newline="", encoding="utf-8-sig") as stream:
        return [
            Share(
                int(row["size"]),
                row["method"],
                int(row["assists"]),
                float(row["solved_at"]),
                float(row["solved_within"]),
                float(row["spread"]),
            )
            for row in csv.DictReader(stream)
        ]


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6f}"
    if isinstance(value, tuple):
        return "+".join(NAMES[k] for k in value)
    return str(value)
