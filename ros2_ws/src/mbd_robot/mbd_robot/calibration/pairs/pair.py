"""A picture of the board and where the tool was when it was taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.views import BoardCorners
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.transforms import Transforms


class BoardMounting(Enum):
    """Which of camera and board moves with the hand."""

    HAND = "hand"
    """The board is on the hand, the camera stands ("eye to hand")."""
    TABLE = "table"
    """The board lies, the camera is on the hand ("eye in hand")."""


@dataclass(frozen=True)
class CalibrationPair:
    """One picture and its tool pose.

    Attributes:
        name: of the picture, for people.
        tool: (4, 4) tool2base [m].
        corners: of the board in the picture.
    """

    name: str
    tool: Transforms
    corners: BoardCorners

    def __post_init__(self) -> None:
        """A pose is a rotation and a place."""
        turn = self.tool[:3, :3]
        if self.tool.shape != (4, 4) or not np.isfinite(self.tool).all():
            raise CalibrationError(f"{self.name}: its tool pose holds numbers that are not finite")
        if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3 or np.linalg.det(turn) < 0.0:
            raise CalibrationError(f"{self.name}: its tool pose is no rotation; expected a unit quaternion x, y, z, w")
        if np.abs(self.tool[:3, 3]).max() > 20.0:
            raise CalibrationError(f"{self.name}: its tool is at {self.tool[:3, 3].round(1)}; expected metres")


@dataclass(frozen=True)
class PairSet:
    """All that a camera's pose is found from.

    Attributes:
        mounting: which of camera and board moves.
        board: that was seen.
        lens: that it was seen through.
        pairs: pictures with their poses.
        base_frame: of the tool poses.
        camera_frame: the optical frame, for the file that is written; "" when unknown.
        blind: names of the pictures in which the board was not found.
    """

    mounting: BoardMounting
    board: BoardPattern
    lens: CalibratedLens
    pairs: Sequence[CalibrationPair]
    base_frame: str = ""
    camera_frame: str = ""
    blind: tuple[str, ...] = ()
