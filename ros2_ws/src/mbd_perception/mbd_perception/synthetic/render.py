"""Frames of a table with known boxes, cylinders and cups, by casting a ray through every pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
from numpy.typing import NDArray

from mbd_perception.frames.frame import DEPTH_NOISE, RgbdFrame
from mbd_perception.synthetic.casting import Box, Cylinder, Rays, Solid, cast, colors_of, plane_depth
from mbd_perception.synthetic.sensors import Optics, Sensor, sense

__all__ = ["KINECT", "Box", "Cylinder", "SyntheticView", "Table", "looking_at", "render"]

KINECT = Intrinsics(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)
TABLE_COLOR = (190, 188, 185)
WALL_COLOR = (220, 220, 210)
# Labels of a view that are no object.
SURROUNDINGS = 1


@dataclass(frozen=True)
class Table:
    """A level table top: height z, (lowest, highest) x and y [m, base frame]; a floor and a wall behind, if any [m]."""

    z: float = 0.0
    x: tuple[float, float] = (0.0, 1.4)
    y: tuple[float, float] = (-0.8, 0.8)
    floor_z: float | None = None
    wall_x: float | None = None


@dataclass(frozen=True)
class SyntheticView:
    """A rendered frame and the truth.

    Attributes:
        frame: what the camera saw.
        labels: (height, width) int32; 0 nothing, 1 table, floor or wall, 2.. the solids in order.
        pose: camera2base it was taken from.
        pixels: how many pixels each solid would cover if nothing hid it, in order.
    """

    frame: RgbdFrame
    labels: NDArray[np.int32]
    pose: CameraPose
    pixels: tuple[int, ...] = ()


def looking_at(position: Sequence[float], target: Sequence[float], roll: float = 0.0) -> CameraPose:
    """A camera at ``position`` looking at ``target`` [m, base frame], its picture upright but for ``roll`` [rad]."""
    eye, aim = np.asarray(position, dtype=np.float64), np.asarray(target, dtype=np.float64)
    z = aim - eye
    z = z / np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    if np.linalg.norm(x) < 1e-6:  # straight down: the top of the picture points away from the robot
        x = np.array([0.0, -1.0, 0.0])
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    x, y = np.cos(roll) * x + np.sin(roll) * y, np.cos(roll) * y - np.sin(roll) * x
    return CameraPose(rotation=np.stack([x, y, z], axis=1), position=eye)


def render(
    solids: Sequence[Solid],
    pose: CameraPose,
    rng: np.random.Generator,
    *,
    table: Table | None = None,
    camera: Intrinsics = KINECT,
    noise: float = DEPTH_NOISE,
    stamp: float = 0.0,
    clutter: Sequence[Solid] = (),
    sensor: Sensor | None = None,
    distortion: float = 0.0,
) -> SyntheticView:
    """Cast a ray through every pixel.

    Args:
        solids: what stands on the table.
        pose: where the camera is.
        rng: for the noise.
        table: the table; a large level one at z = 0 when None.
        camera: its optics.
        noise: std of inverse depth [1/m], as of a structured-light camera; depth is then rounded to 1 mm.
        stamp: time of the frame [s].
        clutter: what else is in the room: chairs, people.
        sensor: another kind of depth camera; ``noise`` is not used then.
        distortion: radial, k1 of the lens: the frame's camera does not know of it.
    """
    columns, rows = camera.rays()
    x, y = np.broadcast_arrays(columns.astype(np.float64), rows.astype(np.float64))
    bent = 1.0 + distortion * (x * x + y * y)
    rays = np.stack([x * bent, y * bent, np.ones_like(x)], axis=-1) @ pose.rotation.T
    eye = pose.position
    distance = np.full(x.shape, np.inf)
    labels = np.zeros(x.shape, dtype=np.int32)
    color = np.zeros((*x.shape, 3))
    for depth, shade, rgb in _surroundings(rays, eye, table or Table()):
        nearer = depth < distance
        distance[nearer], labels[nearer] = depth[nearer], SURROUNDINGS
        color[nearer] = np.asarray(rgb) * shade
    numbered = [(solid, number) for number, solid in enumerate(solids, start=2)]
    complete = []
    for solid, number in numbered + [(thing, SURROUNDINGS) for thing in clutter]:
        window = _around(solid, camera, pose, 1.0 + abs(distortion))
        depth, shades = cast(rays[window], eye, solid)
        complete.append(int(np.isfinite(depth).sum()))
        nearer = depth < distance[window]
        distance[window][nearer], labels[window][nearer] = depth[nearer], number
        points = eye + rays[window][nearer] * depth[nearer][:, None]
        color[window][nearer] = colors_of(solid, points) * shades[nearer][:, None]
    frame = sense(distance, color, Optics(camera, stamp), sensor or Sensor(noise=noise), rng)
    return SyntheticView(frame, np.where(frame.depth > 0, labels, 0), pose, tuple(complete[: len(solids)]))


def _around(solid: Solid, camera: Intrinsics, pose: CameraPose, widening: float) -> tuple[slice, slice]:
    """The part of the picture a solid can be in: the rectangle around its upright box, or all when it is too near."""
    radius, height = solid.reach
    corners = np.array([(x, y, z) for x in (-radius, radius) for y in (-radius, radius) for z in (0.0, height)])
    seen = (corners + np.asarray(solid.foot) - pose.position) @ pose.rotation
    if seen[:, 2].min() < 0.1 or widening > 1.0:
        return slice(None), slice(None)
    u = camera.fx * seen[:, 0] / seen[:, 2] + camera.cx
    v = camera.fy * seen[:, 1] / seen[:, 2] + camera.cy
    low, high = np.floor([v.min(), u.min()]), np.ceil([v.max(), u.max()]) + 1
    (top, left), (bottom, right) = np.clip([low, high], 0, [camera.height, camera.width]).astype(int).tolist()
    return slice(top, bottom), slice(left, right)


def _surroundings(rays: Rays, eye: Rays, table: Table) -> list[tuple[Rays, float, tuple[int, int, int]]]:
    """(depth, shade, colour) of table top, floor and wall."""
    found: list[tuple[Rays, float, tuple[int, int, int]]] = []
    depth = plane_depth(rays, eye, 2, table.z)
    point = eye + rays * np.where(np.isfinite(depth), depth, 0.0)[..., None]
    on_top = (point[..., 0] > table.x[0]) & (point[..., 0] < table.x[1])
    on_top &= (point[..., 1] > table.y[0]) & (point[..., 1] < table.y[1])
    found.append((np.where(on_top, depth, np.inf), 1.0, TABLE_COLOR))
    if table.floor_z is not None:
        found.append((plane_depth(rays, eye, 2, table.floor_z), 0.6, TABLE_COLOR))
    if table.wall_x is not None:
        found.append((plane_depth(rays, eye, 0, table.wall_x), 0.9, WALL_COLOR))
    return found
