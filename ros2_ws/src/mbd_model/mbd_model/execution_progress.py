"""How far the robot has got."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Status(IntEnum):
    """Of a step or of the whole; values equal mbd_msgs/Progress."""

    PLANNED = 1
    UNDER_WAY = 2
    DONE = 3
    FAILED = 4
    FINISHED = 5
    LEFT_OUT = 6


@dataclass(frozen=True)
class Progress:
    """What is published of the work.

    Attributes:
        step_index: 0-based step the status is about, -1 when it is about none.
        status: of that step; FAILED: the robot waits to be told; FINISHED: nothing is left to do.
        text: a sentence for people.
        step_statuses: of each step of the task.
    """

    step_index: int
    status: Status
    text: str
    step_statuses: tuple[Status, ...] = ()
