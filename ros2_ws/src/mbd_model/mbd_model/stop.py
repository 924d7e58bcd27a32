"""A stop of the robot, latched until a person lets it go on: a value that many nodes share without a master.

Each node keeps the highest stop and the highest release it has received, and nothing moves while the stop is above.
Both only grow, so it does not matter in which order, how often, or by which node they are received.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

from mbd_model.errors import MbdError

HIGHEST = 2**63  # far above any number that is counted from the wall clock [ns]


class StopCause(IntEnum):
    """Why everything stands; values equal mbd_msgs/Stop."""

    UNKNOWN = 0
    PERSON = 1
    EMERGENCY_STOP = 2
    PROTECTIVE_STOP = 3
    DRIVER_LOST = 4


class MotionError(IntEnum):
    """Why a motion failed; values equal mbd_msgs/MoveTool and MoveGripper.

    Only NOT_REACHED is tried again by itself; after the others a person lets the robot go on.
    """

    NONE = 0
    NOT_REACHED = 1
    EMERGENCY_STOP = 2
    PROTECTIVE_STOP = 3
    DRIVER_LOST = 4
    CANCELED = 5


@dataclass(frozen=True)
class StopLatch:
    """What a node knows of stops.

    Attributes:
        stopped: number of the last stop, 0 for none yet.
        released: number of the last stop after which a person let the robot go on.
        cause: of the last stop.
        reason: of the last stop, a sentence for people.

    Raises:
        MbdError: more was released than stopped, or a number is too high to count on from.
    """

    stopped: int = 0
    released: int = 0
    cause: StopCause = StopCause.UNKNOWN
    reason: str = ""

    def __post_init__(self) -> None:
        """Refuse what would let later stops go by."""
        if not 0 <= self.released <= self.stopped < HIGHEST:
            raise MbdError(
                f"stop {self.stopped} with release {self.released}: expected numbers below 2**63, the release at most "
                "the stop"
            )

    @property
    def held(self) -> bool:
        """Nothing may move."""
        return self.stopped > self.released

    def stop(self, now: int, cause: StopCause, reason: str) -> StopLatch:
        """The latch after another stop.

        Args:
            now: the wall clock [ns], so that stops of nodes that know nothing of each other differ too.
            cause: why.
            reason: the same for people.
        """
        number = max(now, self.stopped + 1)
        return replace(self, stopped=number, cause=cause, reason=reason)

    def release(self) -> StopLatch:
        """The latch after a person let the robot go on; a stop that was not received yet still holds then."""
        return replace(self, released=self.stopped)

    def merged(self, other: StopLatch) -> StopLatch:
        """What both know."""
        newer = other if other.stopped > self.stopped else self
        return replace(newer, released=max(self.released, other.released))
