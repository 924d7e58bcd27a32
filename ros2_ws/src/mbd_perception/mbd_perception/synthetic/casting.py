"""Where rays meet boxes, cylinders, cups and planes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.synthetic.paint import Paint, Rgb

Rays = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """An upright box.

    Attributes:
        foot: centre of its foot (x, y, z) [m, base frame].
        size: (depth along x, width along y, height) [m].
        color: RGB.
        yaw: about z [rad].
        paint: its print; None for one colour.
    """

    foot: tuple[float, float, float]
    size: tuple[float, float, float]
    color: Rgb
    yaw: float = 0.0
    paint: Paint | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """(radius, height) [m] of a cylinder around it."""
        return 0.5 * math.hypot(self.size[0], self.size[1]), self.size[2]


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder, or a cup.

    Attributes:
        foot: centre of its foot [m, base frame].
        radius, height: [m].
        color: RGB.
        wall: thickness [m] of a cup that is open on top; 0 for a solid one.
        paint: its print; None for one colour.
    """

    foot: tuple[float, float, float]
    radius: float
    height: float
    color: Rgb
    wall: float = 0.0
    paint: Paint | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """(radius, height) [m] of a cylinder around it."""
        return self.radius, self.height


Solid = Box | Cylinder


def cast(rays: Rays, eye: Rays, solid: Solid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depth along (..., 3) rays from ``eye`` [base frame] at which they meet a solid, inf where they do not; shade."""
    return _cast_box(rays, eye, solid) if isinstance(solid, Box) else _cast_cylinder(rays, eye, solid)


def colors_of(solid: Solid, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) RGB, unshaded, of a solid at (n, 3) points of its surface [m, base frame]."""
    if solid.paint is None:
        return np.broadcast_to(np.asarray(solid.color, dtype=np.float64), points.shape)
    local = points - np.asarray(solid.foot)
    size = (2 * solid.radius, 2 * solid.radius, solid.height) if isinstance(solid, Cylinder) else solid.size
    if isinstance(solid, Box):
        local = local @ _turn(solid.yaw).T
    return solid.paint.over(solid.color, local, size)


def _turn(yaw: float) -> NDArray[np.float64]:
    """Base frame to the frame of a box turned by ``yaw``."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])


def plane_depth(rays: Rays, eye: Rays, axis: int, value: float) -> NDArray[np.float64]:
    """Depth at which rays meet the plane where that coordinate has that value; inf where they do not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (value - eye[axis]) / rays[..., axis]
    return np.where(np.isfinite(depth) & (depth > 0), depth, np.inf)


def _cast_box(rays: Rays, eye: Rays, box: Box) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depth and shade of a box by the slab method."""
    turn = _turn(box.yaw)
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


def _cast_cylinder(rays: Rays, eye: Rays, solid: Cylinder) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depth and shade of a cylinder, or of a cup: outer wall, rim, inner wall and inner floor."""
    origin = eye - np.asarray(solid.foot)
    outer = _wall_depths(rays, origin, solid.radius, 0.0, solid.height)[0]
    top = plane_depth(rays, origin, 2, solid.height)
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
    floor = plane_depth(rays, origin, 2, solid.wall)
    floor = np.where(through & (_radius_at(rays, origin, floor) <= inside), floor, np.inf)
    shade[rim < outer] = 1.0
    shade[np.minimum(inner, floor) < np.minimum(outer, rim)] = 0.6
    return np.minimum(np.minimum(outer, rim), np.minimum(inner, floor)), shade


def _radius_at(rays: Rays, origin: Rays, depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance from the axis at which a ray is at that depth; inf where depth is."""
    hit = np.isfinite(depth)
    point = origin[:2] + rays[..., :2] * np.where(hit, depth, 0.0)[..., None]
    return np.where(hit, np.hypot(point[..., 0], point[..., 1]), np.inf)


def _wall_depths(
    rays: Rays, origin: Rays, radius: float, low: float, high: float
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
