"""The joints of arm and hand, gathered from messages that each hold some of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mbd_robot.motion.standstill import Stated

SET_BACK = 1.0  # [s] by which a message may be older than the last and only have been overtaken


@dataclass(frozen=True)
class JointReading:
    """One joint as it was last stated.

    Attributes:
        position: [rad or m]
        velocity: [rad/s or m/s], NaN where the driver gives none.
        stamp: [s] of the message.
        number: how many there were of it.
    """

    position: float
    velocity: float
    stamp: float
    number: int = 1


class JointMerge:
    """Merges joint states by name, whatever their order, their topic and what else they hold.

    Args:
        arm: names of the arm's joints.
        hand: names of the hand's joints.
    """

    def __init__(self, arm: Sequence[str], hand: Sequence[str]) -> None:
        self.arm, self.hand = tuple(arm), tuple(hand)
        self._read: dict[str, JointReading] = {}

    def take(
        self, stamp: float, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float] = ()
    ) -> bool:  # fmt: skip
        """Take a message's joints; whether one of the arm's was among them.

        A message a little older than what is known of a joint, or without a position for it, changes nothing. One that
        is much older is of a driver whose clock was set back: an arm is not planned for from where it was before.

        Args:
            stamp: [s]
            names: of its joints.
            positions: of as many [rad or m].
            velocities: of as many, or none.
        """
        of_arm = False
        for i, name in enumerate(names):
            if name not in self.arm and name not in self.hand:
                continue
            if i >= len(positions) or not math.isfinite(positions[i]):
                continue
            known = self._read.get(name)
            if known is not None and known.stamp - SET_BACK < stamp < known.stamp:
                continue
            velocity = float(velocities[i]) if i < len(velocities) else math.nan
            number = 1 if known is None else known.number + 1
            self._read[name] = JointReading(float(positions[i]), velocity, stamp, number)
            of_arm = of_arm or name in self.arm
        return of_arm

    def missing(self, names: Iterable[str] | None = None) -> tuple[str, ...]:
        """Joints that were never stated."""
        return tuple(n for n in (names if names is not None else (*self.arm, *self.hand)) if n not in self._read)

    def readings(self, names: Iterable[str]) -> tuple[JointReading, ...] | None:
        """Of these joints in this order; None while one is missing."""
        wanted = tuple(names)
        return None if self.missing(wanted) else tuple(self._read[n] for n in wanted)

    def arm_positions(self) -> tuple[float, ...] | None:
        """Of the arm's joints [rad]; None while one is missing."""
        read = self.readings(self.arm)
        return None if read is None else tuple(r.position for r in read)

    def hand_position(self) -> float | None:
        """Mean of the hand's joints [rad or m]; None while one is missing."""
        stated = self.hand_stated()
        return None if stated is None else stated.values[0]

    def hand_stated(self) -> Stated | None:
        """Mean of the hand's joints [rad or m], as often as the rarest; None while one is missing."""
        read = self.readings(self.hand)
        if read is None:
            return None
        return Stated(min(r.number for r in read), (sum(r.position for r in read) / len(read),))

    def newest(self) -> float:
        """Stamp of the oldest of the arm's joints [s]; minus infinity while one is missing."""
        read = self.readings(self.arm)
        return -math.inf if read is None else min(r.stamp for r in read)
