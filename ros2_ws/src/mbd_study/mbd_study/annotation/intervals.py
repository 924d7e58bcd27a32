"""Labelled spans of time, and a session's events as such."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mbd_study.tables.events import EventRow

# How long an event without duration is shown, unless the next comes sooner [s].
SHOWN = 0.5
_TIERS = {
    "prompt": "robot",
    "word": "operator",
    "note": "notes",
    "speech": "teacher",
    "marker": "markers",
    "estimate": "mapping",
}


@dataclass(frozen=True)
class Interval:
    """A label from ``start`` to ``end`` [s from the bag's start], in a tier."""

    tier: str
    start: float
    end: float
    label: str


def session_intervals(rows: Sequence[EventRow], duration: float) -> tuple[Interval, ...]:
    """A session's events by tier: phases and prompts until the next, all else for a moment; none overlaps in its tier.

    Args:
        rows: in order.
        duration: of the bag [s].
    """
    points: dict[str, list[tuple[float, str]]] = {}
    for row in rows:
        tier = "phase" if row.kind == "phase" else _TIERS.get(row.kind, "")
        if row.kind == "reply" and row.accepted is False:
            tier = "refused"
        if tier:
            points.setdefault(tier, []).append((row.time_s, _label(row)))
    found = []
    for tier, marks in points.items():
        # Only a skewed reply is out of order; ELAN wants its tier sorted.
        marks.sort(key=lambda mark: mark[0])
        for start, label, following in _merged(marks, duration):
            end = following if tier in ("phase", "robot") else min(following, start + SHOWN)
            if round(end, 3) > round(start, 3):
                found.append(Interval(tier, start, end, label))
    return tuple(found)


def _label(row: EventRow) -> str:
    if row.kind in ("prompt", "note") or row.accepted is False:
        return row.text
    parts = [row.topic.rpartition("/")[2] if row.kind == "word" else "", row.name, row.target]
    if row.kind == "estimate":
        parts.append(row.text)
    return " ".join(dict.fromkeys(part for part in parts if part))


def _merged(marks: Sequence[tuple[float, str]], duration: float) -> list[tuple[float, str, float]]:
    """(start, label, start of the next) of each moment; labels of one millisecond in one, joined by " | "."""
    moments: list[tuple[float, list[str]]] = []
    for time, label in marks:
        if moments and round(moments[-1][0], 3) == round(time, 3):
            moments[-1][1].append(label)
        else:
            moments.append((time, [label]))
    ends = [time for time, _ in moments[1:]] + [max(duration, moments[-1][0] + SHOWN)]
    return [(time, " | ".join(labels), end) for (time, labels), end in zip(moments, ends, strict=True)]


def by_tier(intervals: Sequence[Interval]) -> Mapping[str, tuple[Interval, ...]]:
    """The intervals of each tier, in order of time."""
    tiers = dict.fromkeys(i.tier for i in intervals)
    return {t: tuple(sorted((i for i in intervals if i.tier == t), key=lambda i: i.start)) for t in tiers}
