"""What an object stands on or in, from boxes alone: before the demonstration, and where it put things.

Solid things do not overlap. A box whose centre is over another's footprint is therefore on it, or inside it when it
fits into it; one whose centre is beside the footprint is on it only if its bottom is at the other's top.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np
from mbd_model.geometry.boxes import distance_to_footprint
from mbd_model.objects import SceneObject

# What perception and a carried pose are off in height, and a wall is thick [m].
HEIGHT_SLACK = 0.015
WALL = 0.005


class Support(StrEnum):
    """How one object holds another up."""

    NONE = "none"
    ONTO = "onto"
    INTO = "into"


def bottom_of(obj: SceneObject) -> float:
    """Height of the lowest point of its box [m, robot base frame]."""
    return obj.centroid[2] - 0.5 * obj.size[2]


def top_of(obj: SceneObject) -> float:
    """Height of the highest point of its box [m, robot base frame]."""
    return obj.centroid[2] + 0.5 * obj.size[2]


def support(upper: SceneObject, lower: SceneObject, margin: float, clearance: float) -> Support:
    """Whether ``lower`` holds ``upper`` up, or will when it has come to rest.

    Args:
        upper: the box that may be held up, robot base frame.
        lower: the other one.
        margin: [m] how far beside the footprint of the lower one the centre of the upper one may be.
        clearance: [m] how far above the top of the lower one the bottom of the upper one may be: it is let go there.
    """
    if bottom_of(upper) > top_of(lower) + clearance:
        return Support.NONE
    beside = distance_to_footprint(upper.centroid, lower)
    on_top = bottom_of(upper) >= top_of(lower) - HEIGHT_SLACK
    if beside > 0.0:
        return Support.ONTO if on_top and beside <= margin else Support.NONE
    if on_top:
        return Support.ONTO
    if fits_into(upper, lower):
        return Support.INTO
    # Its centre is over the other one and it does not fit inside: its height is misjudged, unless it only leans there.
    over = inside_by(upper, lower) > min(HEIGHT_SLACK, 0.25 * min(lower.size[:2]))
    return Support.ONTO if over else Support.NONE


def inside_by(upper: SceneObject, lower: SceneObject) -> float:
    """How far the centre of ``upper`` is inside the footprint of ``lower`` [m]; negative outside."""
    x, y = _in_box_axes(upper, lower)
    width, depth, _ = lower.size
    return min(0.5 * depth - abs(x), 0.5 * width - abs(y))


def fits_into(upper: SceneObject, lower: SceneObject) -> bool:
    """Whether the footprint of ``upper``, where it is, lies within the walls of ``lower``."""
    x, y = _in_box_axes(upper, lower)
    turn = upper.yaw - lower.yaw
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    width, depth, _ = upper.size
    reach_x, reach_y = 0.5 * (cos * depth + sin * width), 0.5 * (sin * depth + cos * width)
    return (
        abs(x) + reach_x <= 0.5 * lower.size[1] + WALL
        and abs(y) + reach_y <= 0.5 * lower.size[0] + WALL
        and bottom_of(upper) >= bottom_of(lower) - HEIGHT_SLACK
    )


def standing_on(objects: tuple[SceneObject, ...], margin: float) -> tuple[tuple[str, str], ...]:
    """(upper id, lower id) of each object that stands on or in another one now."""
    found = []
    for upper in objects:
        below = [
            lower
            for lower in objects
            if lower is not upper
            and bottom_of(upper) > bottom_of(lower) - HEIGHT_SLACK
            and _lower_first(lower, upper)
            and support(upper, lower, margin, HEIGHT_SLACK) is not Support.NONE
        ]
        if below:
            # Of a stack the next one below carries it.
            found.append((upper.object_id, max(below, key=top_of).object_id))
    return tuple(found)


def _lower_first(lower: SceneObject, upper: SceneObject) -> bool:
    """Whether ``lower`` can be the one below: its bottom is lower, or (one inside the other) it is the larger one."""
    rise = bottom_of(upper) - bottom_of(lower)
    return rise > HEIGHT_SLACK or np.prod(lower.size) > np.prod(upper.size)


def _in_box_axes(upper: SceneObject, lower: SceneObject) -> tuple[float, float]:
    """(x, y) of the centre of ``upper`` from that of ``lower`` along the sides of the lower box [m]."""
    x, y = upper.centroid[0] - lower.centroid[0], upper.centroid[1] - lower.centroid[1]
    cos, sin = math.cos(lower.yaw), math.sin(lower.yaw)
    return cos * x + sin * y, cos * y - sin * x
