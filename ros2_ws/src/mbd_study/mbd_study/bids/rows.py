"""What stands in a session's two BIDS tables: its events, and its estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from mbd_study.tables.data_dictionary import DICTIONARY
from mbd_study.tables.events import EventRow
from mbd_study.tables.table_rows import EstimateRow

NOTHING = "n/a"
_LASTING = frozenset({"phase", "prompt"})
_RENAMED = {"time_s": "onset", "kind": "trial_type", "latency_s": "response_time", "published_s": "onset"}
_KINDS = {
    "prompt": "the robot asks or says something",
    "word": "the operator enters what the participant did, or a command",
    "note": "the operator notes something",
    "marker": "the operator marks a moment",
    "reply": "the dialogue accepts or refuses a word",
    "phase": "a phase of the session begins",
    "estimate": "an object mapping is computed",
    "speech": "the simulated teacher speaks",
    "form": "the participant sends a form in",
    "stop": "everything stops, or goes on",
    "service": "a service is called",
}
Cells = Mapping[str, Any]


def event_cells(rows: Sequence[EventRow], duration: float, *, notes: bool) -> list[Cells]:
    """The events in order of their onset; phases and prompts last until the next of their kind, all else no time.

    Args:
        rows: of a session.
        duration: of its bag [s].
        notes: keep the text of notes.
    """
    found: list[Cells] = []
    ordered = sorted(rows, key=lambda r: r.time_s)
    ends = dict.fromkeys(_LASTING, duration)
    for row in reversed(ordered):
        lasts = max(0.0, ends[row.kind] - row.time_s) if row.kind in _LASTING else 0.0
        if row.kind in _LASTING:
            ends[row.kind] = row.time_s
        cells = {_RENAMED.get(k, k): v for k, v in asdict(row).items() if k != "session"}
        if row.kind in ("note", "marker") and not notes:
            cells["text"] = ""
        first = {"onset": round(row.time_s, 6), "duration": round(lasts, 6), "trial_type": row.kind}
        found.append(first | {k: v for k, v in cells.items() if k not in first})
    return found[::-1]


def estimate_cells(rows: Sequence[EstimateRow]) -> list[Cells]:
    """The estimates of a session."""
    return [{_RENAMED.get(k, k): v for k, v in asdict(row).items() if k != "session"} for row in rows]


def columns_of(table: str) -> dict[str, dict[str, Any]]:
    """What the columns of a table hold, as BIDS sidecars state it.

    Args:
        table: "events" or "estimates".
    """
    words = {_RENAMED.get(name, name): text for name, text in DICTIONARY[table].items() if name != "session"}
    found: dict[str, dict[str, Any]] = {name: {"Description": text} for name, text in words.items()}
    for name in ("onset", "response_time"):
        if name in found:
            found[name]["Units"] = "s"
    if table == "events":
        found["duration"] = {"Description": "of a phase or prompt until the next of its kind; else 0", "Units": "s"}
        found["trial_type"]["Levels"] = dict(_KINDS)
    return found


def cell_text(value: Any) -> str:
    """A value as BIDS writes it: n/a for none, no tabulator or end of line within.

    Args:
        value: of a cell.
    """
    if value is None or value == "":
        return NOTHING
    if isinstance(value, bool):
        return str(value).lower()
    return " ".join(str(value).split()) or NOTHING
