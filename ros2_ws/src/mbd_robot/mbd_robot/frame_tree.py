"""Frames as tf2 publishes them: the newest transform of each, and chains of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mbd_robot.geometry import RobotToolPose

LONGEST = 200  # frames in a chain; more is a circle


@dataclass(frozen=True)
class FrameTransform:
    """Where a frame is in its parent.

    Attributes:
        parent: name of the other frame.
        position: (3,) [m]
        quaternion: (4,) x, y, z, w.
        stamp: [s]; None of one that never changes.
    """

    parent: str
    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]
    stamp: float | None = None


@dataclass(frozen=True)
class FramePose:
    """Where a frame is in another, and since when [s]; -inf where nothing between the two ever moves."""

    pose: RobotToolPose
    stamp: float


class FrameTree:
    """Keeps the newest transform of each frame.

    robot_state_publisher sends all links of one joint state together, so that the newest of each belong together; no
    transform is interpolated to another's time.
    """

    def __init__(self) -> None:
        self._of: dict[str, FrameTransform] = {}

    def put(self, frame: str, transform: FrameTransform) -> bool:
        """Take a transform; False for one older than what is known of the frame, and for no rotation."""
        length = float(np.linalg.norm(transform.quaternion))
        if not np.isfinite(transform.position).all() or not abs(length - 1.0) < 0.01:
            return False
        known = self._of.get(_plain(frame))
        if known is not None and _newer(known, transform):
            return False
        self._of[_plain(frame)] = transform
        return True

    def chain(self, frame: str) -> tuple[str, ...]:
        """The frame and its ancestors, as far as they are known."""
        found = [_plain(frame)]
        while (at := self._of.get(found[-1])) is not None and len(found) < LONGEST:
            found.append(_plain(at.parent))
        return tuple(found)

    def pose(self, base: str, frame: str) -> FramePose | None:
        """Where ``frame`` is in ``base``; None while they are not connected."""
        below, above = self.chain(frame), self.chain(base)
        meeting = next((name for name in below if name in above), None)
        if meeting is None:
            return None
        position, rotation, down = self._up(below[: below.index(meeting)])
        other, turned, up = self._up(above[: above.index(meeting)])
        inverse = turned.inv()
        pose = RobotToolPose(inverse.apply(position - other), (inverse * rotation).as_quat())
        return FramePose(pose, min(down, up) if np.isfinite(min(down, up)) else max(down, up))

    def _up(self, frames: tuple[str, ...]) -> tuple[NDArray[np.float64], Rotation, float]:
        """From the first frame to the last one's parent: position, rotation, and the oldest stamp [s]."""
        position, rotation = np.zeros(3), Rotation.identity()
        stamps = []
        for name in frames:
            at = self._of[name]
            turn = Rotation.from_quat(at.quaternion)
            position, rotation = np.asarray(at.position) + turn.apply(position), turn * rotation
            if at.stamp is not None:
                stamps.append(at.stamp)
        return position, rotation, min(stamps, default=-np.inf)


def _newer(one: FrameTransform, other: FrameTransform) -> bool:
    return one.stamp is not None and other.stamp is not None and one.stamp > other.stamp


def _plain(name: str) -> str:
    """Some older publishers put a slash before the name."""
    return name.removeprefix("/")
