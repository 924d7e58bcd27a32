"""Figure 10: what the confidence threshold does to the assists asked for and to the tasks done right (paper sec. 7).

The robot asks on until its confidence reaches the threshold, and does the other steps alone. Autonomy is the share of
the steps it does without an assist.
"""

from __future__ import annotations

from collections.abc import Sequence

from mbd_experiments.csv_table import CsvCell, CsvRow
from mbd_experiments.user_study.assists_needed import Sessions, groups_by_task
from mbd_experiments.user_study.predictions import SessionPrediction

ALL_TASKS = "all"
# The rule's confidence is a difference of similarities, the paper looks at 0 to 0.25; that of "evidence" is a
# probability.
THRESHOLDS = {
    "mbd": tuple(k / 200 for k in range(51)),
    "evidence": (*(k / 50 for k in range(50)), 0.99, 0.995, 0.999),
}


def stop(session: Sequence[SessionPrediction], threshold: float) -> SessionPrediction:
    """The prediction the robot goes on with: the first confident one, else that after the last assist."""
    return next((p for p in session if p.confidence >= threshold), session[-1])


def autonomy(prediction: SessionPrediction) -> float:
    """Share of the steps done alone."""
    return max(0.0, 1.0 - prediction.assists / prediction.steps) if prediction.steps else 0.0


def figure10(predictions: Sequence[SessionPrediction]) -> list[CsvRow]:
    """One row for each strategy, threshold and task (and all tasks together), and one for each of the baselines.

    ``policy``: "confident" (with a threshold), "unguided" (no assist at all), "relearning" (every step shown again).
    """
    groups = groups_by_task(predictions)
    together: dict[tuple[str, str, str], list[tuple[SessionPrediction, ...]]] = {}
    for (origin, strategy, _), sessions in groups.items():
        together.setdefault((origin, strategy, ALL_TASKS), []).extend(sessions)
    rows: list[CsvRow] = []
    for (origin, strategy, task), sessions in (together | groups).items():
        fixed: dict[str, CsvCell] = {"origin": origin, "strategy": strategy, "task": task, "sessions": len(sessions)}
        for threshold in THRESHOLDS[strategy]:
            stops = [stop(s, threshold) for s in sessions]
            rows.append({**fixed, "policy": "confident", "threshold": f"{threshold:g}", **_means(stops)})
        rows.append({**fixed, "policy": "unguided", "threshold": "", **_means([s[0] for s in sessions])})
        rows.append({**fixed, "policy": "relearning", "threshold": "", **_relearning(sessions)})
    return rows


def best_thresholds(rows: Sequence[CsvRow]) -> list[CsvRow]:
    """For each strategy and task the threshold that gets most tasks right, of several the one with fewest assists.

    ``also_best_to`` is the last of the thresholds in a row that do as well.
    """
    groups: dict[tuple[str, str, str], list[CsvRow]] = {}
    for row in rows:
        if row["policy"] == "confident":
            groups.setdefault((str(row["origin"]), str(row["strategy"]), str(row["task"])), []).append(row)
    found: list[CsvRow] = []
    for group in groups.values():
        best = min(group, key=lambda r: (-int(r["correct"]), float(r["assists"]), float(r["threshold"])))
        same = [r for r in group if (r["correct"], r["assists"]) == (best["correct"], best["assists"])]
        found.append({**best, "also_best_to": same[-1]["threshold"]})
    return found


def _means(stops: Sequence[SessionPrediction]) -> dict[str, CsvCell]:
    count = len(stops)
    return {
        "correct": sum(p.correct for p in stops),
        "share": sum(p.correct for p in stops) / count,
        "assists": sum(p.assists for p in stops) / count,
        "autonomy": sum(autonomy(p) for p in stops) / count,
    }


def _relearning(sessions: Sessions) -> dict[str, CsvCell]:
    """What is shown again step by step is right, and nothing of it is done alone."""
    return {
        "correct": len(sessions),
        "share": 1.0,
        "assists": sum(s[0].steps for s in sessions) / len(sessions),
        "autonomy": 0.0,
    }
