"""Frames of a camera that is mounted on its side or upside down, turned so that what is up is up in the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.table.plane import Plane, Vector

# Looking down more steeply than this there is no up in the picture, and nothing is turned: 12 degrees off the vertical.
STEEP = 0.2


def quarter_turns(normal: Vector) -> int:
    """Counter-clockwise quarter turns (0-3) of the picture after which a table's ``normal`` points up in it."""
    if float(np.hypot(normal[0], normal[1])) < STEEP:
        return 0
    ups = [-float(turned_normal(normal, turns)[1]) for turns in range(4)]
    return int(np.argmax(ups))


def turned_normal(vector: Vector, turns: int) -> Vector:
    """(3,) a vector of the optical frame in that of the picture turned counter-clockwise ``turns`` times."""
    x, y, z = vector
    for _ in range(turns % 4):
        x, y = y, -x
    return np.array([x, y, z])


def turned_camera(camera: Intrinsics, turns: int) -> Intrinsics:
    """The camera of the turned picture."""
    for _ in range(turns % 4):
        camera = Intrinsics(
            camera.fy, camera.fx, camera.cy, camera.width - 1 - camera.cx, width=camera.height, height=camera.width
        )
    return camera


def turned_frame(frame: RgbdFrame, turns: int) -> RgbdFrame:
    """The frame with its picture turned counter-clockwise ``turns`` times; its points turn about the line of sight."""
    return replace(
        frame,
        color=np.ascontiguousarray(np.rot90(frame.color, turns)),
        depth=np.ascontiguousarray(np.rot90(frame.depth, turns)),
        camera=turned_camera(frame.camera, turns),
    )


def turned_plane(plane: Plane, turns: int) -> Plane:
    """The same plane, in the optical frame of the turned picture."""
    return Plane(turned_normal(plane.normal, turns), plane.offset)
