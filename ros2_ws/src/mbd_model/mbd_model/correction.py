"""A correction of the demonstrated task by the teacher: what is asked for, by service, topic or page."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class CorrectionKind(IntEnum):
    """What is changed; values equal those of mbd_msgs/ReviseTask and WizardRevision, which say what each does."""

    DELETE = 1
    MOVE = 2
    CHANGE_OBJECT = 3
    SPLIT = 4
    JOIN = 5
    RERECORD = 6


@dataclass(frozen=True)
class StepCorrection:
    """One correction of a task.

    Attributes:
        kind: what is changed.
        step: the step it is about, 0-based.
        to: of MOVE: the step before whose pick it is to come, 0-based; the number of steps: to the end.
        object_id: of CHANGE_OBJECT: the source object meant; the present one: there is no doubt about it.
        at: of SPLIT: when the object was put down on the way [s].
    """

    kind: CorrectionKind
    step: int
    to: int = 0
    object_id: str = ""
    at: float = 0.0
