"""The tool's path during a demonstration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import ArrayLike, NDArray


class TrajectoryError(MbdError):
    """A recording from which no path of the tool can be made."""


@dataclass(frozen=True)
class ToolPose:
    """Where the tool was.

    Attributes:
        position: (3,) [m, robot base frame].
        quaternion: (4,) x, y, z, w of unit length.
    """

    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]


@dataclass(frozen=True)
class ToolTrajectory:
    """Tool poses in order of time, one for each stamp.

    Attributes:
        stamps: (n,) strictly increasing [s].
        positions: (n, 3) [m, robot base frame].
        quaternions: (n, 4) x, y, z, w of unit length, each in the hemisphere of the one before.
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]

    @classmethod
    def from_samples(cls, stamps: ArrayLike, positions: ArrayLike, quaternions: ArrayLike) -> ToolTrajectory:
        """Make a trajectory of samples as they arrived.

        Samples may be out of order and repeated, and single ones may be broken (NaN, zero quaternion): they are
        sorted by stamp; of equal stamps the first is kept, broken samples are left out.

        Raises:
            TrajectoryError: the shapes do not fit, or no usable sample is left.
        """
        t = np.asarray(stamps, dtype=float)
        p = np.asarray(positions, dtype=float)
        q = np.asarray(quaternions, dtype=float)
        if t.size == 0:
            raise TrajectoryError("no tool pose was recorded: is the robot's driver publishing out/tool_pose?")
        if t.ndim != 1 or p.shape != (t.size, 3) or q.shape != (t.size, 4):
            raise TrajectoryError(
                f"{t.shape} stamps, {p.shape} positions and {q.shape} quaternions; expected (n,), (n, 3) and (n, 4)"
            )
        norms = np.linalg.norm(q, axis=1)
        usable = np.isfinite(t) & np.isfinite(p).all(axis=1) & np.isfinite(norms) & (norms > 1e-6)
        if not usable.any():
            raise TrajectoryError(f"none of {t.size} tool poses is usable: each holds NaN or a zero quaternion")
        t, p, q = t[usable], p[usable], q[usable] / norms[usable, None]
        t, first = np.unique(t, return_index=True)  # sorts, and keeps the first of equal stamps
        p, q = p[first], q[first]
        flips = np.sign((q[1:] * q[:-1]).sum(axis=1))
        q[1:] *= np.cumprod(np.where(flips == 0.0, 1.0, flips))[:, None]
        return cls(t, p, q)

    def pose_at(self, stamp: float) -> ToolPose:
        """The pose at a time [s], interpolated linearly; before the first sample the first, after the last the last."""
        position = np.array([np.interp(stamp, self.stamps, self.positions[:, k]) for k in range(3)])
        quaternion = np.array([np.interp(stamp, self.stamps, self.quaternions[:, k]) for k in range(4)])
        return ToolPose(position, quaternion / np.linalg.norm(quaternion))

    def gap_at(self, stamp: float) -> float:
        """How far the samples that ``pose_at`` used lie from a time [s]: 0 on a sample, the farther of two between."""
        after = int(np.searchsorted(self.stamps, stamp))
        around = self.stamps[max(after - 1, 0) : after + 1]
        if stamp in around:
            return 0.0
        if after in (0, self.stamps.size):
            return float(np.abs(around - stamp).min())
        return float(np.abs(around - stamp).max())

    def between(self, start: float, end: float) -> NDArray[np.float64]:
        """Positions (n, 3) [m, robot base frame] between two times [s], those at both ends included."""
        inside = self.positions[(self.stamps >= start) & (self.stamps <= end)]
        return np.vstack([self.pose_at(start).position, inside, self.pose_at(end).position])

    def farthest_from(self, point: ArrayLike, start: float, end: float, *, down: bool = True) -> float:
        """Largest distance [m] of the tool to a point (3,) [m, robot base frame] between two times [s].

        ``down``: whether going below the point counts.
        """
        way = self.between(start, end) - np.asarray(point, dtype=float)
        if not down:
            way[:, 2] = np.maximum(way[:, 2], 0.0)
        return float(np.linalg.norm(way, axis=1).max())

    def rise_above(self, height: float, start: float, end: float) -> float:
        """How far the tool came above a height [m, robot base frame] between two times [s]; negative: never."""
        return float(self.between(start, end)[:, 2].max()) - height
