"""What can go wrong while the robot works alone: each failure's name, what the robot tries by itself, and how often.

After that it asks the teacher in one sentence, and takes the answer: "yes" (it is put right: go on), another object,
"skip" (leave it out), or a stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.execution_progress import Failure


class Recovery(StrEnum):
    """What the robot tries by itself."""

    NOTHING = "nothing"
    ANOTHER_GRASP = "another grasp"
    AGAIN = "the same again"
    LOOK_AND_PICK_AGAIN = "looks where it is now and picks it up again"
    PUT_BACK = "puts it back and takes the right one"
    LOOK_AGAIN = "looks again"


@dataclass(frozen=True)
class Handling:
    """How a failure is dealt with.

    Attributes:
        recovery: what the robot tries by itself.
        limit: how often it may happen to the same object before the teacher is asked; 1: asked at once.
        request: what the teacher is asked to do; {held} the objects in question, {it} that they belong, {them} they.
    """

    recovery: Recovery
    limit: int
    request: str


PUT_RIGHT = "please put it right and say yes, give me another one, or skip it"

HANDLING = {
    Failure.NO_COUNTERPART: Handling(Recovery.NOTHING, 1, "please give me one, or skip it"),
    Failure.NOT_GRASPED: Handling(Recovery.ANOTHER_GRASP, 3, PUT_RIGHT),
    Failure.SLIPPED: Handling(Recovery.LOOK_AND_PICK_AGAIN, 3, PUT_RIGHT),
    Failure.WRONG_OBJECT: Handling(Recovery.PUT_BACK, 2, "please take it out of my hand and say yes, or skip it"),
    Failure.NOT_IN_PLACE: Handling(
        Recovery.LOOK_AND_PICK_AGAIN, 2, "please put {held} where {it} and say yes, or skip {them}"
    ),
    Failure.NOT_THERE: Handling(
        Recovery.LOOK_AGAIN, 2, "please put it back and say yes, give me another one, or skip it"
    ),
    Failure.FALLEN_OVER: Handling(
        Recovery.NOTHING, 1, "please set it upright and say yes, give me another one, or skip it"
    ),
    Failure.WHICH_ONE: Handling(Recovery.NOTHING, 1, "is that so? yes or no"),
    Failure.NO_WAY: Handling(Recovery.ANOTHER_GRASP, 3, PUT_RIGHT),
    Failure.HAND_ZONE: Handling(
        Recovery.NOTHING, 1, "please move it out of there and say yes, give me another one, or skip it"
    ),
    Failure.NOT_SEEN: Handling(
        Recovery.LOOK_AGAIN, 2, "please clear the view and say yes, or skip and I go on without looking"
    ),
}


class Trouble(NamedTuple):
    """What the robot asks about.

    Attributes:
        step: index of the step it is about.
        why: a sentence for people, what they are asked to do included.
        failure: its name.
        otherwise: where everything is if the answer is no; None unless the question is which of two.
        done: the step is of a transfer that was done already.
        also: ids of further objects that the same request is about, the nearer to the table first.
    """

    step: int
    why: str
    failure: Failure = Failure.NONE
    otherwise: TrackedObjects | None = None
    done: bool = False
    also: tuple[str, ...] = ()


def trouble(
    failure: Failure,
    step: int,
    what: str,
    held: str = "",
    otherwise: TrackedObjects | None = None,
    *,
    done: bool = False,
    also: tuple[str, ...] = (),
) -> Trouble:
    """The question to the teacher about a failure: what happened, and what to do about it.

    Args:
        failure: its name.
        step: index of the step it is about.
        what: what happened, without a full stop.
        held: the object it happened to.
        otherwise: where everything is if the answer is no.
        done: the step is of a transfer that was done already.
        also: further objects that it happened to, the nearer to the table first.
    """
    it, them = ("they belong", "them") if also else ("it belongs", "it")
    request = HANDLING[failure].request.format(held=listed((held, *also)), it=it, them=them)
    return Trouble(step, f"{what}: {request}", failure, otherwise, done, also)


def listed(names: Sequence[str]) -> str:
    """Names as a sentence has them: "t1, t2 and t3"."""
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)
