"""The lines of the operator's event log."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

LOG_LENGTH = 200  # lines kept


class Tone(StrEnum):
    """What kind of line the event log has."""

    PHASE = "phase"
    ROBOT = "robot"
    TEACHER = "teacher"
    ACCEPTED = "accepted"
    REFUSED = "refused"
    NOTE = "note"
    MAPPING = "mapping"


@dataclass(frozen=True)
class LogLine:
    """A line of the event log: when [s, session clock], what kind, who it comes from, and what."""

    at: float
    tone: Tone
    speaker: str
    text: str
