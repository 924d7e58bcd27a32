"""Figure 9: in how many sessions the mapping is right within k assists, against unguided transfer and relearning."""

from __future__ import annotations

from collections.abc import Sequence

from mbd_experiments.csv_table import CsvRow
from mbd_experiments.user_study.predictions import SessionPrediction, by_session

Sessions = Sequence[tuple[SessionPrediction, ...]]


def groups_by_task(
    predictions: Sequence[SessionPrediction],
) -> dict[tuple[str, str, str], list[tuple[SessionPrediction, ...]]]:
    """Sessions by (origin, strategy, task)."""
    groups: dict[tuple[str, str, str], list[tuple[SessionPrediction, ...]]] = {}
    for (origin, strategy, task, _), session in by_session(predictions).items():
        groups.setdefault((origin, strategy, task), []).append(session)
    return groups


def at(session: Sequence[SessionPrediction], assists: int) -> SessionPrediction:
    """The prediction after so many assists, or after the last one given."""
    return session[min(assists, len(session) - 1)]


def figure9(predictions: Sequence[SessionPrediction]) -> list[CsvRow]:
    """One row for each task, strategy and number k of assists, 0 to the number of steps.

    ``within``: sessions right after k assists or fewer; ``correct``: right after exactly k; ``unguided``: right without
    any (Algorithm 2); ``relearning``: sessions whose every step the teacher has shown again by then.
    """
    rows: list[CsvRow] = []
    for (origin, strategy, task), sessions in groups_by_task(predictions).items():
        for count in range(max(s[0].steps for s in sessions) + 1):
            rows.append(
                {
                    "origin": origin,
                    "strategy": strategy,
                    "task": task,
                    "assists": count,
                    "sessions": len(sessions),
                    "correct": sum(at(s, count).correct for s in sessions),
                    "within": sum(any(p.correct for p in s[: count + 1]) for s in sessions),
                    "unguided": sum(s[0].correct for s in sessions),
                    "relearning": sum(count >= s[0].steps for s in sessions),
                }
            )
    return rows
