"""Which of several hands was taught, and what it did."""

from __future__ import annotations

from collections.abc import Mapping

from mbd_model.errors import MbdError
from numpy.typing import ArrayLike

from mbd_demonstration.finger_joint import FingerJointConfig, GripperReading, read_gripper
from mbd_demonstration.hand.fingers import combined, hands, resampled

# Of a finger that comes less often than the others: known between samples so far apart at most [s].
LONGEST_GAP = 1.0


def read_hands(
    series: Mapping[str, tuple[ArrayLike, ArrayLike]], config: FingerJointConfig
) -> tuple[GripperReading, tuple[str, ...]]:
    """What the hand that moved did, and a sentence for each finger of it that was left out or turned round.

    Args:
        series: (stamps [s], positions), (n,) both, of each finger joint by name; those of several hands by prefix.
        config: how closings are read.

    Raises:
        MbdError: more than one hand moved.
    """
    readings = {}
    for hand, joints in hands(tuple(series)).items():
        stamps, positions = resampled({name: series[name] for name in joints}, LONGEST_GAP)
        one = combined(positions)
        readings[hand] = (read_gripper(stamps, one.values, config), one.notes)
    moved = {hand: entry for hand, entry in readings.items() if entry[0].events or entry[0].half_closings}
    if len(moved) > 1:
        raise MbdError(
            f"{len(moved)} hands moved ({sorted(moved)}, by the names of their joints {sorted(series)}): "
            "which one is taught is not known; give its joints as finger_joints"
        )
    return next(iter((moved or readings).values()))
