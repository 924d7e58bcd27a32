"""What the features of rendered objects really are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from mbd_perception.features.color import ColorConfig, object_color
from mbd_perception.synthetic.casting import Box, Cylinder, Solid, cast, colors_of
from mbd_perception.synthetic.rooms import RandomRoom
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TrueFeatures:
    """Of one object; None where there is no truth.

    Attributes:
        centroid: (x, y, z) mean of the points of it that can be seen [m].
        box_center: (x, y, z) middle of all of it [m], on the table as everything is taken to stand on it.
        size: (width, depth, height above the table) [m], hidden parts included, at ``yaw``.
        yaw: [rad]; None for what is round.
        hue: [deg] of its complete surface; None when it is grey.
        saturation: of its complete surface.
    """

    centroid: Floats
    box_center: Floats | None = None
    size: tuple[float, float, float] | None = None
    yaw: float | None = None
    hue: float | None = None
    saturation: float | None = None


def true_features(room: RandomRoom, number: int, coloured: bool) -> TrueFeatures:
    """The truth about solid ``number`` (from 1) of a room; ``coloured``: whether its colours can be seen."""
    solid = room.solids[number - 1]
    x, y, foot = solid.foot
    top = foot + solid.reach[1]
    if isinstance(solid, Box):
        size, yaw = (solid.size[1], solid.size[0], top), solid.yaw
    else:
        size, yaw = (2 * solid.radius, 2 * solid.radius, top), None
    points = surface_points(solid)
    look = object_color(np.clip(colors_of(solid, points), 0, 255).astype(np.uint8), ColorConfig())
    return TrueFeatures(
        centroid=visible_mean(room, number),
        box_center=np.array([x, y, 0.5 * top]),
        size=size,
        yaw=yaw,
        hue=look.hue if coloured else None,
        saturation=look.saturation if coloured else None,
    )


def visible_mean(room: RandomRoom, number: int) -> Floats:
    """(3,) mean of the points of a solid that the camera sees, without its noise [m, base frame]."""
    camera, pose = room.view.frame.camera, room.view.pose
    v, u = np.nonzero(room.truth == number)
    columns, rows = camera.rays()
    rays = np.stack([columns[0, u], rows[v, 0], np.ones(len(u))], axis=1).astype(np.float64) @ pose.rotation.T
    depth, _ = cast(rays, pose.position, room.solids[number - 1])
    hit = np.isfinite(depth)
    if not hit.any():  # a lens bent so much that no ray is where it seems
        depth = room.view.frame.depth[v, u].astype(np.float64)
        hit = depth > 0
    return np.asarray((pose.position + rays[hit] * depth[hit, None]).mean(axis=0))


def surface_points(solid: Solid, steps: int = 24) -> Floats:
    """(n, 3) points spread evenly over the top and the upright faces of a solid [m, base frame]."""
    spread = (np.arange(steps) + 0.5) / steps
    a, b = (v.ravel() for v in np.meshgrid(spread, spread))
    faces = _cylinder_faces(solid, a, b) if isinstance(solid, Cylinder) else _box_faces(solid, a, b)
    largest = max(area for area, _ in faces)
    local = np.concatenate([face[:: max(1, round(largest / area))] for area, face in faces])
    turn = solid.yaw if isinstance(solid, Box) else 0.0
    cos, sin = math.cos(turn), math.sin(turn)
    level = local[:, :2] @ np.array([[cos, sin], [-sin, cos]])
    return np.asarray(np.column_stack([level, local[:, 2]]) + np.asarray(solid.foot))


def _cylinder_faces(solid: Cylinder, a: Floats, b: Floats) -> list[tuple[float, Floats]]:
    """(area, (n, 3) points) of wall and lid, in the solid's frame; ``a``, ``b`` (n,) 0..1."""
    angle, radius = 2 * math.pi * a, solid.radius * np.sqrt(b)
    wall = np.stack([solid.radius * np.cos(angle), solid.radius * np.sin(angle), solid.height * b], axis=1)
    lid = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(a), solid.height)], axis=1)
    return [(2 * math.pi * solid.radius * solid.height, wall), (math.pi * solid.radius**2, lid)]


def _box_faces(solid: Box, a: Floats, b: Floats) -> list[tuple[float, Floats]]:
    """(area, (n, 3) points) of the four upright faces and the top, in the solid's frame; ``a``, ``b`` (n,) 0..1."""
    x, y, z = solid.size
    across, along, up = x * (a - 0.5), y * (a - 0.5), z * b
    faces = [(x * y, np.stack([across, y * (b - 0.5), np.full(len(a), z)], axis=1))]
    for side in (-0.5, 0.5):
        faces.append((y * z, np.stack([np.full(len(a), side * x), along, up], axis=1)))
        faces.append((x * z, np.stack([across, np.full(len(a), side * y), up], axis=1)))
    return faces
