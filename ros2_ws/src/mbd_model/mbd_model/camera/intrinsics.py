"""The lens of a camera: a pinhole without distortion, validated once where it enters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbd_model.errors import MbdError

Rays = NDArray[np.float32]


class CameraError(MbdError):
    """A camera that no picture can come from."""


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera without distortion.

    Attributes:
        fx, fy: focal lengths [px].
        cx, cy: principal point [px], pixel centres at integers.
        width, height: image size [px].
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        """Raises CameraError for a camera that no picture can come from."""
        numbers = (self.fx, self.fy, self.cx, self.cy)
        if not all(math.isfinite(v) for v in numbers) or self.fx <= 0 or self.fy <= 0:
            raise CameraError(
                f"camera intrinsics fx={self.fx} fy={self.fy} cx={self.cx} cy={self.cy} are not usable: "
                "focal lengths must be positive; is the camera_info of this camera published?"
            )
        if self.width < 1 or self.height < 1:
            raise CameraError(f"camera image size {self.width}x{self.height} is empty; check camera_info")

    def window(self, top: int, left: int, height: int, width: int) -> Intrinsics:
        """The camera of a part of the picture: the same rays, counted from another corner [px]."""
        return Intrinsics(self.fx, self.fy, self.cx - left, self.cy - top, width=width, height=height)

    def rays(self) -> tuple[Rays, Rays]:
        """(x/z of every column, shape (1, width); y/z of every row, shape (height, 1)) in the optical frame.

        Worked out once and shared: they cannot be written to.
        """
        return self._rays

    @cached_property
    def _rays(self) -> tuple[Rays, Rays]:
        """What ``rays`` returns."""
        columns = (np.arange(self.width, dtype=np.float32) - np.float32(self.cx)) / np.float32(self.fx)
        rows = (np.arange(self.height, dtype=np.float32) - np.float32(self.cy)) / np.float32(self.fy)
        columns.setflags(write=False)
        rows.setflags(write=False)
        return columns[None, :], rows[:, None]
