"""How the dialogue behaves."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_model.estimate import QuestionKind


class QuestionOrder(StrEnum):
    """Which open step is asked about first."""

    TASK = "task"
    INFORMATIVE = "informative"


@dataclass(frozen=True)
class DialogueConfig:
    """How the dialogue behaves.

    Attributes:
        point_reach: [m] a pointed place means the nearest target object whose surface is at most this far away.
        question_order: in task order, as in the study; or first the step the mapping would learn most from.
        execute: a robot executes the task in EXECUTE, and its progress is waited for.
        question_kinds: how it may ask about a step, where the mapping would learn most that way for the teacher's
            time; openly always.
        doubt_asked: a demonstrated step whose runner-up was meant with this probability is asked about.
    """

    point_reach: float = 0.15
    question_order: QuestionOrder = QuestionOrder.TASK
    execute: bool = False
    question_kinds: tuple[QuestionKind, ...] = (QuestionKind.WHAT_NEXT,)
    doubt_asked: float = 0.1
