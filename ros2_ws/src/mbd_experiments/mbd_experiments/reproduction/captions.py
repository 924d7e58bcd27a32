"""What stands under every table and figure: what it shows, of which sessions, and whether those are real."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbd_experiments.user_study.study_facts import Origin

TITLES = {
    "table4": "Table 4. The tasks",
    "table5": "Table 5. Consistent demonstrations and assists, and how many of the sessions with both have the right "
    "mapping once all assists are given",
    "figure9": "Figure 9. Sessions with the right mapping within k assists",
    "figure10": "Figure 10. Confidence threshold, assists asked for, tasks done right, autonomy",
    "best_thresholds": "Best thresholds: most tasks right, then fewest assists",
}


def caption(item: str, origin: Origin, rows: Sequence[Mapping[str, str]]) -> str:
    """The caption of a table or figure drawn from ``rows`` of its CSV."""
    words = origin.words[0].upper() + origin.words[1:]
    return f"{TITLES[item]}. {words}, {sessions_in(rows)} sessions."


def sessions_in(rows: Sequence[Mapping[str, str]]) -> int:
    """How many sessions a table with columns task and sessions covers; the rows of all tasks together count once."""
    per_task = {row["task"]: int(row["sessions"]) for row in rows}
    return per_task.get("all", sum(per_task.values()))


def origins_in(rows: Sequence[Mapping[str, str]]) -> list[Origin]:
    """The origins of a table, each once."""
    return [Origin(o) for o in dict.fromkeys(row["origin"] for row in rows)]
