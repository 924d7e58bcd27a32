"""Frames of a table with known boxes, cylinders and cups, by casting a ray through every pixel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.frame import DEPTH_NOISE, Intrinsics, RgbdFrame, make_frame
from mbd_perception.pose import CameraPose, Matrix

KINECT = Intrinsics(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)
TABLE_COLOR = (190, 188, 185)
WALL_COLOR = (220, 220, 210)


@dataclass(frozen=True)
class Box:
    """An upright box: centre of its foot (x, y, z) [m], (depth along x, width along y, height) [m], yaw [rad], RGB."""

    foot: tuple[float, float, float]
    size: tuple[float, float, float]
    color: tuple[int, int, int]
    yaw: float = 0.0


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder: centre of its foot, radius, height [m], RGB; ``wall`` [m] makes it a cup, open on top."""

    foot: tuple[float, float, float]
    radius: float
    height: float
    color: tuple[int, int, int]
    wall: float = 0.0


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
    """

    frame: RgbdFrame
    labels: NDArray[np.int32]
    pose: CameraPose


def looking_at(position: Sequence[float], target: Sequence[float]) -> CameraPose:
    """A camera at ``position`` looking at ``target`` [m, base frame], its picture upright."""
    eye, aim = np.asarray(position, dtype=np.float64), np.asarray(target, dtype=np.float64)
    z = aim - eye
    z = z / np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    if np.linalg.norm(x) < 1e-6:  # straight down: the top of the picture points away from the robot
        x = np.array([0.0, -1.0, 0.0])
    x = x / np.linalg.norm(x)
    return CameraPose(rotation=np.stack([x, np.cross(z, x), z], axis=1), position=eye)


def render(
    solids: Sequence[Box | Cylinder],
    pose: CameraPose,
    rng: np.random.Generator,
    *,
    table: Table | None = None,
    camera: Intrinsics = KINECT,
    noise: float = DEPTH_NOISE,
    stamp: float = 0.0,
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
    """
    columns, rows = camera.rays()
    x, y = np.broadcast_arrays(columns.astype(np.float64), rows.astype(np.float64))
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ pose.rotation.T
    distance = np.full(x.shape, np.inf)
    labels = np.zeros(x.shape, dtype=np.int32)
    color = np.zeros((*x.shape, 3))
    for depth, shade, rgb in _surroundings(rays, pose.position, table or Table()):
        nearer = depth < distance
        distance[nearer], labels[nearer] = depth[nearer], 1
        color[nearer] = np.asarray(rgb) * shade
    for number, solid in enumerate(solids, start=2):
        if isinstance(solid, Box):
            depth, shade_map = _cast_box(rays, pose.position, solid)
        else:
            depth, shade_map = _cast_cylinder(rays, pose.position, solid)
        nearer = depth < distance
        distance[nearer], labels[nearer] = depth[nearer], number
        color[nearer] = np.asarray(solid.color) * shade_map[nearer][:, None]
    hit = np.isfinite(distance)
    disparity = np.where(hit, 1.0 / np.where(hit, distance, 1.0), 0.0)
    disparity = disparity + rng.normal(0.0, noise, disparity.shape)
    millimetres = np.where(hit & (disparity > 0.02), 1000.0 / np.maximum(disparity, 0.02), 0.0)
    rgb8 = np.clip(color + rng.normal(0.0, 2.0, color.shape) * hit[..., None], 0, 255).astype(np.uint8)
    frame = make_frame(rgb8, np.rint(millimetres).astype(np.uint16), camera, stamp)
    return SyntheticView(frame=frame, labels=np.where(frame.depth > 0, labels, 0), pose=pose)


def _surroundings(
    rays: Matrix, eye: Matrix, table: Table
) -> list[tuple[NDArray[np.float64], float, tuple[int, int, int]]]:
    """(depth, shade, colour) of table top, floor and wall."""
    found: list[tuple[NDArray[np.float64], float, tuple[int, int, int]]] = []
    depth = _plane_depth(rays, eye, 2, table.z)
    point = eye + rays * np.where(np.isfinite(depth), depth, 0.0)[..., None]
    on_top = (point[..., 0] > table.x[0]) & (point[..., 0] < table.x[1])
    on_top &= (point[..., 1] > table.y[0]) & (point[..., 1] < table.y[1])
    found.append((np.where(on_top, depth, np.inf), 1.0, TABLE_COLOR))
    if table.floor_z is not None:
        found.append((_plane_depth(rays, eye, 2, table.floor_z), 0.6, TABLE_COLOR))
    if table.wall_x is not None:
        found.append((_plane_depth(rays, eye, 0, table.wall_x), 0.9, WALL_COLOR))
    return found


def _plane_depth(rays: Matrix, eye: Matrix, axis: int, value: float) -> NDArray[np.float64]:
    """Depth at which rays meet the plane where that coordinate has that value; inf where they do not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (value - eye[axis]) / rays[..., axis]
    return np.where(np.isfinite(depth) & (depth > 0), depth, np.inf)


def _cast_box(rays: Matrix, eye: Matrix, box: Box) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depth and shade of a box by the slab method."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    direction = rays @ turn.T
    origin = turn @ (eye - np.asarray(box.foot))
    low = np.array([-box.size[0] / 2, -box.size[1] / 2, 0.0])
    high = np.array([box.size[0] / 2, box.size[1] / 2, box.size[2]])
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - origin) / direction, (high - origin) / direction
    enter, leave = np.minimum(first, second), np.maximum(first, second)
    depth = enter.max(axis=-1)
    hit = (depth > 0) & (depth < leave.min(axis=-1))
    shade = np.choose(enter.argmax(axis=-1), [0.7, 0.85, 1.0])
    return np.where(hit, depth, np.inf), shade


def _cast_cylinder(rays: Matrix, eye: Matrix, solid: Cylinder) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depth and shade of a cylinder, or of a cup: outer wall, rim, inner wall and inner floor."""
    origin = eye - np.asarray(solid.foot)
    outer = _wall_depths(rays, origin, solid.radius, 0.0, solid.height)[0]
    top = _plane_depth(rays, origin, 2, solid.height)
    radius_at_top = _radius_at(rays, origin, top)
    shade = np.full(top.shape, 0.8)
    if solid.wall <= 0:
        lid = np.where(radius_at_top <= solid.radius, top, np.inf)
        shade[lid < outer] = 1.0
        return np.minimum(outer, lid), shade
    inside = solid.radius - solid.wall
    rim = np.where((radius_at_top <= solid.radius) & (radius_at_top >= inside), top, np.inf)
    through = radius_at_top < inside
    inner = np.where(through, _wall_depths(rays, origin, inside, solid.wall, solid.height)[1], np.inf)
    floor = _plane_depth(rays, origin, 2, solid.wall)
    floor = np.where(through & (_radius_at(rays, origin, floor) <= inside), floor, np.inf)
    shade[rim < outer] = 1.0
    shade[np.minimum(inner, floor) < np.minimum(outer, rim)] = 0.6
    return np.minimum(np.minimum(outer, rim), np.minimum(inner, floor)), shade


def _radius_at(rays: Matrix, origin: Matrix, depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance from the axis at which a ray is at that depth; inf where depth is."""
    hit = np.isfinite(depth)
    point = origin[:2] + rays[..., :2] * np.where(hit, depth, 0.0)[..., None]
    return np.where(hit, np.hypot(point[..., 0], point[..., 1]), np.inf)


def _wall_depths(
    rays: Matrix, origin: Matrix, radius: float, low: float, high: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depths at which rays enter and leave a cylinder wall between two heights; inf where they do not."""
    a = rays[..., 0] ** 2 + rays[..., 1] ** 2
    b = rays[..., 0] * origin[0] + rays[..., 1] * origin[1]
    c = origin[0] ** 2 + origin[1] ** 2 - radius**2
    square = b * b - a * c
    meets = (square > 0) & (a > 1e-12)
    root = np.sqrt(np.where(meets, square, 0.0))
    divisor = np.where(meets, a, 1.0)
    both = []
    for sign in (-1.0, 1.0):
        depth = (-b + sign * root) / divisor
        z = origin[2] + rays[..., 2] * depth
        both.append(np.where(meets & (depth > 0) & (z >= low) & (z <= high), depth, np.inf))
    return both[0], both[1]
