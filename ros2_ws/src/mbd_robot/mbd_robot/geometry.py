"""Where the tool is, and what stands around the arm, as values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.parameters import ParameterError
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

ZONE_HEIGHT = 2.0  # [m] above the table: no arm of ours passes over it
FINGERS = 0.09  # [m] from the hand's middle, to the side: a zone is larger by them, as they count for nothing elsewhere


@dataclass(frozen=True)
class RobotToolPose:
    """Where the suite's tool is: z along the fingers, closing along y.

    Attributes:
        position: (3,) [m, base frame].
        quaternion: (4,) x, y, z, w.
    """

    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]

    @property
    def rotation(self) -> Rotation:
        """Of the tool's axes in the base frame."""
        return Rotation.from_quat(self.quaternion)


@dataclass(frozen=True)
class Obstacle:
    """A box that the arm keeps clear of.

    Attributes:
        name: of the object.
        centre: (3,) [m, base frame].
        size: (3,) [m] along x, y, z at yaw 0.
        yaw: about the vertical [rad].
    """

    name: str
    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float = 0.0


@dataclass(frozen=True)
class HeldBoxes:
    """What is in the hand, and all on it.

    Attributes:
        boxes: where they were when the hand closed [m, base frame].
        grasp: the tool then.
    """

    boxes: tuple[Obstacle, ...] = ()
    grasp: RobotToolPose | None = None


@dataclass(frozen=True)
class Surroundings:
    """What an arm at work has around it.

    Attributes:
        obstacles: boxes to keep clear of.
        held: what is in its hand.
    """

    obstacles: tuple[Obstacle, ...] = ()
    held: HeldBoxes = HeldBoxes()


def hand_zone_box(zone: Sequence[float], table_height: float) -> Obstacle | None:
    """The teacher's hands as a box that the arm keeps clear of; None for a zone of nothing.

    Args:
        zone: x_min, x_max, y_min, y_max [m, base frame].
        table_height: of the table's top [m].

    Raises:
        ParameterError: they are not four numbers, or no box.
    """
    if len(zone) != 4 or not all(math.isfinite(v) for v in zone) or zone[0] > zone[1] or zone[2] > zone[3]:
        raise ParameterError(f"hand_zone is {list(zone)}: expected x_min <= x_max and y_min <= y_max [m]")
    if not any(zone):
        return None
    x_min, x_max, y_min, y_max = zone
    size = (x_max - x_min + 2 * FINGERS, y_max - y_min + 2 * FINGERS, ZONE_HEIGHT)
    middle = ((x_min + x_max) / 2, (y_min + y_max) / 2, table_height + ZONE_HEIGHT / 2)
    return Obstacle("the teacher's hands", middle, size)
