"""How far the robot has got."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Status(IntEnum):
    """Of a step or of the complete task; values equal mbd_msgs/Progress."""

    PLANNED = 1
    UNDER_WAY = 2
    DONE = 3
    FAILED = 4
    FINISHED = 5
    LEFT_OUT = 6
    STOPPED = 7


class Purpose(IntEnum):
    """What a course of the arm's motions is for; values equal mbd_msgs/Progress.PURPOSE_*."""

    NONE = 0
    PICK = 1
    PLACE = 2
    FETCH = 3
    RETURN = 4
    LET_GO = 5
    LOOK = 6

    @property
    def words(self) -> str:
        """It in words, before the name of an object."""
        return PURPOSE_WORDS[self]


PURPOSE_WORDS = {
    Purpose.NONE: "do nothing with",
    Purpose.PICK: "pick up",
    Purpose.PLACE: "set down",
    Purpose.FETCH: "take back",
    Purpose.RETURN: "put back",
    Purpose.LET_GO: "let go of",
    Purpose.LOOK: "look again before I use",
}


class Failure(IntEnum):
    """What went wrong for good; values equal mbd_msgs/Progress.FAILURE_*.

    NO_COUNTERPART: the mapping has no object for a step. NOT_GRASPED: the hand closed on nothing. SLIPPED: it was lost
    on the way. WRONG_OBJECT: another one is in the hand. NOT_IN_PLACE: it does not stand where it was put. NOT_THERE:
    it is not seen any more. FALLEN_OVER: it lies. WHICH_ONE: it may be another one. NO_WAY: no free way leads there.
    HAND_ZONE: it is where the teacher's hands are. NOT_SEEN: perception does not see the table.
    """

    NONE = 0
    NO_COUNTERPART = 1
    NOT_GRASPED = 2
    SLIPPED = 3
    WRONG_OBJECT = 4
    NOT_IN_PLACE = 5
    NOT_THERE = 6
    FALLEN_OVER = 7
    WHICH_ONE = 8
    NO_WAY = 9
    HAND_ZONE = 10
    NOT_SEEN = 11


class Verdict(IntEnum):
    """What the teacher answered to a failure; values equal mbd_msgs/SessionState.VERDICT_*."""

    NONE = 0
    YES = 1
    NO = 2


@dataclass(frozen=True)
class Progress:
    """What is published of the work.

    Attributes:
        step_index: 0-based step the status is about, -1 when it is about none.
        status: of that step; FAILED: the robot waits for instructions; FINISHED: nothing is left to do;
            STOPPED: everything stands until a person resumes.
        text: a sentence for people; nothing may depend on its words.
        step_statuses: of each step of the task.
        purpose: what the arm's motions are for.
        object_id: the target object they are about, "" for none.
        receiver_id: the target object it is set down onto, "" for none or the table.
        failure: of a FAILED step, what went wrong.
    """

    step_index: int
    status: Status
    text: str
    step_statuses: tuple[Status, ...] = ()
    purpose: Purpose = Purpose.NONE
    object_id: str = ""
    receiver_id: str = ""
    failure: Failure = Failure.NONE

    @property
    def doing(self) -> tuple[int, Status, Purpose, str, str]:
        """What the arm is at: another one is worth another line of a log."""
        return (self.step_index, self.status, self.purpose, self.object_id, self.receiver_id)
