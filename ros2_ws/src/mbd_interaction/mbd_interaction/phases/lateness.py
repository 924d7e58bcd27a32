"""Whether an answer is older than the question that it would answer: it was meant for the one before."""

from __future__ import annotations

from dataclasses import replace

from mbd_interaction.dialogue import Dialogue, EventRefusedError
from mbd_interaction.events import CLOCK_TOLERANCE, Event


def refuse_late(dialogue: Dialogue, event: Event) -> None:
    """Raises EventRefusedError for an event that is older than the question asked now."""
    if event.at < dialogue.asked_at - CLOCK_TOLERANCE:
        raise EventRefusedError("late: this answer is older than the question asked now; answer that one")


def asked_by(dialogue: Dialogue, now: int) -> Dialogue:
    """The dialogue with its question asked at ``now`` [ns] at the latest.

    A clock that was ahead for one message, or that of a sender, dates a question into the future: every answer would be
    late until then.
    """
    return dialogue if dialogue.asked_at <= now else replace(dialogue, asked_at=now)
