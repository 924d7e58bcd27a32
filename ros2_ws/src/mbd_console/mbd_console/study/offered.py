"""The session that a study's plan has next, as what leads the session offers it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OfferedSession:
    """What is offered once the present session is over.

    Attributes:
        session: its name; "" when the plan has none left.
        participant: who comes, a pseudonym.
        task, condition: of the study.
        problem: why it cannot begin, "" when it can.
    """

    session: str
    participant: str
    task: str
    condition: str
    problem: str = ""
