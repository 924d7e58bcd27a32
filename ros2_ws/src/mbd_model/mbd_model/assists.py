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
        confirmed: the teacher was asked "is that so?" and said yes: from then on it is certain.
    """

    source_id: str
    target_id: str
    step_index: int = 0
    kind: AssistKind = AssistKind.HANDED
    stamp: float = 0.0
    confirmed: bool = False


@dataclass(frozen=True)
class Denial:
    """The teacher's "no": ``target_id`` is not the one for ``source_id``.

    It answers "is this the one for that?"; "neither" to "which of these two?" is two denials. A "yes", or one of the
    two, is an ordinary assist.

    Attributes:
        source_id: the object that was asked about.
        target_id: the object that is not its counterpart.
        step_index: 0-based index of the step it was asked for.
        stamp: when it was given [s].
    """

    source_id: str
    target_id: str
    step_index: int = 0
    stamp: float = 0.0
