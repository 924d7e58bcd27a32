"""What each strategy predicts in each session after each number of assists: the table all others are made of."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import HERE

from mbd_experiments.csv_table import read_csv, write_csv
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.study_facts import Origin

STRATEGY_NAMES = ("mbd", "evidence")


@dataclass(frozen=True)
class SessionPrediction:
    """One inference.

    Attributes:
        origin, strategy, task, participant, session: of what, by what.
        steps: of the demonstrated task.
        assists: it was made from.
        correct: whether every object used goes to an acceptable target.
        confidence: 0..1.
        ties: how many mappings share the best value.
        feature: what gave it, joined by "+".
    """

    origin: Origin
    strategy: str
    task: str
    participant: str
    session: str
    steps: int
    assists: int
    correct: bool
    confidence: float
    ties: int
    feature: str


def predict(case: Case, strategy: str) -> tuple[SessionPrediction, ...]:
    """After 0, 1, ... all of the session's assists, in the order given.

    The strategy that a session ran with keeps the session's configuration (for the study the number -1000 as a hue);
    another one takes the product's own, which is the same in every tool.
    """
    own = case.config.strategy == strategy
    config = case.config if own else MappingConfig(strategy=strategy)
    found = []
    for count in range(len(case.assists) + 1):
        estimate = infer(case.task, case.target, case.assists[:count], config)
        found.append(
            SessionPrediction(
                origin=case.origin,
                strategy=strategy,
                task=case.task_name,
                participant=case.participant,
                session=case.name,
                steps=len(case.task.steps),
                assists=count,
                correct=case.solved_by(estimate.mapping.as_dict),
                confidence=estimate.confidence,
                ties=estimate.ties,
                feature="+".join(estimate.winning),
            )
        )
    return tuple(found)


def write_predictions(
    cases: Sequence[Case], path: Path, strategies: Sequence[str] = STRATEGY_NAMES, executor: Executor = HERE
) -> Path:
    """Predict everything and write it as CSV; returns the path."""
    work = list(itertools.product(strategies, cases))
    rows = []
    for predictions in executor.run_all(_predicted, work, lambda item: f"{item[1].name} by {item[0]}"):
        for p in predictions:
            # Confidence decides against thresholds, so the file keeps all of it.
            rows.append({**vars(p), "correct": int(p.correct), "confidence": repr(p.confidence)})
    return write_csv(path, rows)


def _predicted(item: tuple[str, Case]) -> tuple[SessionPrediction, ...]:
    strategy, case = item
    return predict(case, strategy)


def read_predictions(path: Path) -> tuple[SessionPrediction, ...]:
    """What `write_predictions` wrote; raises BagError when there is no such file."""
    return tuple(
        SessionPrediction(
            origin=Origin(row["origin"]),
            strategy=row["strategy"],
            task=row["task"],
            participant=row["participant"],
            session=row["session"],
            steps=int(row["steps"]),
            assists=int(row["assists"]),
            correct=row["correct"] == "1",
            confidence=float(row["confidence"]),
            ties=int(row["ties"]),
            feature=row["feature"],
        )
        for row in read_csv(path)
    )


def by_session(
    predictions: Sequence[SessionPrediction],
) -> dict[tuple[str, str, str, str], tuple[SessionPrediction, ...]]:
    """Each session's predictions by number of assists; keys (origin, strategy, task, session), in the order met."""
    groups: dict[tuple[str, str, str, str], list[SessionPrediction]] = {}
    for p in predictions:
        groups.setdefault((str(p.origin), p.strategy, p.task, p.session), []).append(p)
    return {key: tuple(sorted(group, key=lambda p: p.assists)) for key, group in groups.items()}
