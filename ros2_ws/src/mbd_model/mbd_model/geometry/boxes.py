"""Distances to an object's bounding box: to its surface, not to its centroid (paper sec. 4.2, 6.5.1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbd_model.objects import SceneObject


def outside_box(point: ArrayLike, obj: SceneObject) -> NDArray[np.float64]:
    """How far a point lies beyond each pair of faces of an object's box.

    Args:
        point: (3,) [m], robot base frame.
        obj: the object; its box is turned by ``yaw`` about z.

    Returns:
        (3,) [m] along the box's own axes (x, y, z), 0 where the point is between the two faces.
    """
    x, y, z = np.asarray(point, dtype=float) - np.asarray(obj.centroid)
    cos, sin = math.cos(obj.yaw), math.sin(obj.yaw)
    along = np.array([cos * x + sin * y, cos * y - sin * x, z])
    width, depth, height = obj.size
    beyond: NDArray[np.float64] = np.maximum(np.abs(along) - 0.5 * np.array([depth, width, height]), 0.0)
    return beyond


def distance_to_box(point: ArrayLike, obj: SceneObject) -> float:
    """Distance [m] from a point (3,) [m, robot base frame] to the box's surface, 0 inside it."""
    return float(np.linalg.norm(outside_box(point, obj)))


def distance_to_footprint(point: ArrayLike, obj: SceneObject) -> float:
    """Horizontal distance [m] from a point (3,) [m, robot base frame] to the box seen from above, 0 over it."""
    return float(np.linalg.norm(outside_box(point, obj)[:2]))


def nearest(point: ArrayLike, objects: tuple[SceneObject, ...]) -> list[tuple[float, SceneObject]]:
    """The objects with their surface distances [m], nearest first.

    Where boxes overlap, as nested cups do, a point may be inside several: then the nearer centroid comes first.
    """

    def order(entry: tuple[float, SceneObject]) -> tuple[float, float]:
        return entry[0], float(np.linalg.norm(np.asarray(point, dtype=float) - np.asarray(entry[1].centroid)))

    return sorted(((distance_to_box(point, obj), obj) for obj in objects), key=order)


def box_corners(thing: SceneObject) -> NDArray[np.float64]:
    """(8, 3) corners of the object's box [m, base frame]: the lower four around, then the upper four."""
    width, depth, height = thing.size
    cos, sin = np.cos(thing.yaw), np.sin(thing.yaw)
    flat = 0.5 * np.array([(depth, width), (depth, -width), (-depth, -width), (-depth, width)])
    turned = flat @ np.array([[cos, sin], [-sin, cos]]) + np.array(thing.centroid[:2])
    heights = thing.centroid[2] + np.array([-0.5, 0.5]) * height
    return np.concatenate([np.column_stack([turned, np.full(4, z)]) for z in heights])
