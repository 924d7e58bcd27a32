"""Assists: what the teacher points out about a step (paper sec. 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class AssistKind(IntEnum):
    """How the teacher answered; values equal mbd_msgs/Assist."""

    HANDED = 1
    POINTED = 2


@dataclass(frozen=True)
class Assist:
    """The claim that source object ``source_id`` of step ``step_index`` corresponds to target object ``target_id``.

    Attributes:
        source_id: the step's primary object.
        target_id: the object the teacher handed over or pointed at.
        step_index: 0-based index of the step it answers.
        kind: handed or pointed.
        stamp: when it was given [s].
    """

    source_id: str
    target_id: str
    step_index: int = 0
    kind: AssistKind = AssistKind.HANDED
    stamp: float = 0.0
