"""The supporting plane of a depth image, found in inverse depth.

A plane is linear in inverse depth: w = 1/z = A x' + B y' + C over the rays x' = x/z, y' = y/z. A structured-light
camera measures disparity, so the noise of w is the same everywhere in the picture, and one tolerance serves near and
far (Khoshelham & Elberink 2012: std of z = 1.5e-3 z^2, that is 1.5e-3 in w). The picture is cut into small blocks;
each flat block is a candidate plane and a vote: no sampling, so the same frame always gives the same plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.frames.frame import DEPTH_NOISE, FloatImage

Vector = NDArray[np.float64]
Blocks = NDArray[np.float64]


class NoTableError(MbdError):
    """No plane in view that objects could stand on."""


@dataclass(frozen=True)
class Plane:
    """The plane normal . p + offset = 0 in the optical frame.

    Attributes:
        normal: (3,) unit vector towards the camera.
        offset: distance of the camera from the plane [m], positive.
    """

    normal: Vector
    offset: float

    def height(self, depth: FloatImage, camera: Intrinsics, out: FloatImage | None = None) -> FloatImage:
        """Height above the plane [m] of every pixel, (height, width) float32; ``offset`` where there is no depth.

        Args:
            depth: (height, width) float32 [m], 0 = none.
            camera: its camera.
            out: (height, width) float32, where to write it; None for a new one.
        """
        x, y = camera.rays()
        down = np.float32(self.normal[1]) * y + np.float32(self.normal[2])
        ramp: FloatImage = np.add(np.float32(self.normal[0]) * x, down, out=out)
        ramp *= depth
        ramp += np.float32(self.offset)
        return ramp

    @cached_property
    def axes(self) -> NDArray[np.float64]:
        """(2, 3) two unit vectors in the plane, square to each other."""
        a, b, c = (float(v) for v in self.normal)
        first = np.array([b, -a, 0.0] if abs(c) < 0.9 else [0.0, c, -b])
        first /= np.linalg.norm(first)
        x, y, z = (float(v) for v in first)
        return np.stack([first, [b * z - c * y, c * x - a * z, a * y - b * x]])

    def tilt(self, up: Vector) -> float:
        """Angle [rad] between the plane's normal and ``up`` (optical frame)."""
        return float(np.arccos(np.clip(self.normal @ up, -1.0, 1.0)))


@dataclass(frozen=True)
class PlaneConfig:
    """How a plane is looked for.

    Attributes:
        noise: std of inverse depth [1/m] of the sensor.
        block: side of a block [px]: small enough to fit between objects, large enough to average noise away.
        max_tilt: largest angle [rad] between table and gravity when the camera's pose is known.
        min_share: smallest share of the blocks with depth that a table fills.
        max_planes: how many planes are distinguished.
        uneven: a picture whose pixels differ by more than this times ``noise`` is noisier than expected.
        bumpiest: a picture whose blocks are uneven is taken to be noisier by this factor at most.
        noisiest: that many times ``noise`` at most.
    """

    noise: float = DEPTH_NOISE
    block: int = 16
    max_tilt: float = 0.26
    min_share: float = 0.02
    max_planes: int = 5
    uneven: float = 1.3
    bumpiest: float = 1.1
    noisiest: float = 8.0


@dataclass(frozen=True)
class PlaneCandidate:
    """A plane that was found.

    Attributes:
        plane: it.
        support: how many flat blocks of the picture lie in it.
        area: of all that is seen of it [m^2].
        patch: of its largest piece in one [m^2]: the lids of equal boxes are many pieces.
        noise: std of inverse depth [1/m] that was reckoned with.
    """

    plane: Plane
    support: int
    area: float
    patch: float
    noise: float
