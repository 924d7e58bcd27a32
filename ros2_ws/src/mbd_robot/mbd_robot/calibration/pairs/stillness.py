"""When a picture is worth keeping: the hand rests, and it is not where it was for the one before."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from mbd_robot.calibration.transforms import Transforms, inverse, logarithm, mean_transform

REST = 0.6  # [s] without a move
MOVE, TURN = 0.0015, 0.006  # [m, rad] within which the hand rests: of a driver's own noise
APART, TURNED = 0.03, 0.10  # [m, rad] beyond which a pose is another one
KEPT = 600  # poses


@dataclass(frozen=True)
class RestingPose:
    """The tool while the hand rests.

    Attributes:
        since: [s] stamp from which it has rested.
        until: [s] newest stamp.
        tool: (4, 4) tool2base, in the middle of all poses since.
    """

    since: float
    until: float
    tool: Transforms


class StillnessWatch:
    """Follows the tool, and says when it rests somewhere new.

    Args:
        rest: [s] that it must have rested.
    """

    def __init__(self, rest: float = REST) -> None:
        self._rest = rest
        self._poses: deque[tuple[float, Transforms]] = deque(maxlen=KEPT)
        self._taken: list[Transforms] = []

    def pose(self, stamp: float, tool: Transforms) -> None:
        """The tool was at ``tool`` (4, 4) at ``stamp`` [s]; a clock that was set back begins again."""
        if self._poses and stamp < self._poses[-1][0]:
            self._poses.clear()
        self._poses.append((stamp, tool))
        while self._poses and not self._same(self._poses[0][1], tool, MOVE, TURN):
            self._poses.popleft()

    def resting(self) -> RestingPose | None:
        """Where the tool rests; None while it moves, or has not rested long enough."""
        if len(self._poses) < 2:
            return None
        since, until = self._poses[0][0], self._poses[-1][0]
        if until - since < self._rest:
            return None
        return RestingPose(since, until, mean_transform(np.stack([tool for _, tool in self._poses])))

    def is_new(self, tool: Transforms) -> bool:
        """Whether no picture was taken near there yet."""
        return not any(self._same(there, tool, APART, TURNED) for there in self._taken)

    def took(self, tool: Transforms) -> None:
        """A picture was taken there."""
        self._taken.append(tool)

    @staticmethod
    def _same(one: Transforms, other: Transforms, move: float, turn: float) -> bool:
        twist = logarithm(inverse(one) @ other)
        return bool(np.linalg.norm(twist[:3]) <= turn and np.linalg.norm(twist[3:]) <= move)
