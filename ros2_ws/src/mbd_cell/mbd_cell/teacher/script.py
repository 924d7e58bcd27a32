"""What an arm or a teacher does over time, as generators that the cell runs one control tick at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mbd_cell.arm.hand import GripperCommand, Hand
from mbd_cell.arm.kinematics import ArmKinematics, DownwardToolPose
from mbd_cell.arm.motion import guided_path


class Word(IntEnum):
    """What the teacher says; values equal mbd_msgs/Speech."""

    OPEN = 1
    CLOSE = 2
    DEMONSTRATION_BEGINS = 3
    DEMONSTRATION_ENDS = 4
    READY = 5


# The simulation clock stands still until the wizard has answered these.
ANSWERED_BY_GRIPPER = {Word.OPEN: GripperCommand.OPEN, Word.CLOSE: GripperCommand.CLOSE}


@dataclass(frozen=True)
class Utterance:
    """A word, spoken now. OPEN and CLOSE wait for the wizard's gripper command, the beginning for his START."""

    word: Word

    @property
    def waits(self) -> bool:
        """True when nothing moves until the wizard has acted on it."""
        return self.word in ANSWERED_BY_GRIPPER or self.word is Word.DEMONSTRATION_BEGINS


# One item a control tick: None (time passes) or a word.
Script = Iterator[Utterance | None]


class SimulatedArm:
    """The arm's joint targets and the tool pose they stand for."""

    def __init__(self, kinematics: ArmKinematics, joints: NDArray[np.float64]) -> None:
        self.kinematics = kinematics
        self.target = np.array(joints, dtype=np.float64)
        self.pose = kinematics.tool_pose(self.target)

    def guide(self, end: DownwardToolPose, speed: float, tremble: float, rng: np.random.Generator) -> Script:
        """Move the tool along a guided path; raises UnreachableError before it moves when the end is out of reach."""
        path = list(guided_path(self.pose, end, speed, tremble, rng))
        solutions = []
        joints = self.target
        for pose in path:
            joints = self.kinematics.solve(pose, joints)
            solutions.append(joints)
        for pose, joints in zip(path, solutions, strict=True):
            self.target, self.pose = joints, pose
            yield None

    def take(self, joints: NDArray[np.float64]) -> None:
        """Take these joint targets (J,) [rad] at once."""
        self.target = np.array(joints, dtype=np.float64)
        self.pose = self.kinematics.tool_pose(self.target)

    def swing(self, joints: NDArray[np.float64], duration: float) -> Script:
        """Move the joints (J,) [rad] there in ``duration`` seconds, minimum jerk."""
        start = self.target.copy()
        count = max(1, round(duration * 100))
        for tick in range(1, count + 1):
            t = tick / count
            self.target = start + (t**3 * (10.0 - 15.0 * t + 6.0 * t * t)) * (joints - start)
            yield None
        self.target = np.array(joints, dtype=np.float64)
        self.pose = self.kinematics.tool_pose(self.target)


def rest(seconds: float) -> Script:
    """Let time pass."""
    for _ in range(round(seconds * 100)):
        yield None


def until_settled(hand: Hand, limit: float = 4.0) -> Script:
    """Let time pass until the fingers have done what they were commanded."""
    for _ in range(round(limit * 100)):
        yield None
        if hand.settled:
            return
