"""Where the tool is, and what stands around the arm, as values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation


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
