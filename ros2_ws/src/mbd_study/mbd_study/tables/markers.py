"""Moments that the operator marked by one key, a row each, taken from the events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbd_study.tables.events import EventRow


@dataclass(frozen=True)
class MarkerRow:
    """One marker; `data_dictionary` states what each column holds."""

    session: str
    marker: int
    time_s: float
    phase: str
    name: str
    text: str


def marker_rows(events: Sequence[EventRow]) -> tuple[MarkerRow, ...]:
    """The markers among a session's events, in their order."""
    marked = [e for e in events if e.kind == "marker"]
    return tuple(MarkerRow(e.session, k, e.time_s, e.phase, e.name, e.text) for k, e in enumerate(marked))
