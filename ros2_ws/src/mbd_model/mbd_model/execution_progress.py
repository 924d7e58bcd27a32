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
}


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
    """

    step_index: int
    status: Status
    text: str
    step_statuses: tuple[Status, ...] = ()
    purpose: Purpose = Purpose.NONE
    object_id: str = ""
    receiver_id: str = ""

    @property
    def doing(self) -> tuple[int, Status, Purpose, str, str]:
        """What the arm is at: another one is worth another line of a log."""
        return (self.step_index, self.status, self.purpose, self.object_id, self.receiver_id)
