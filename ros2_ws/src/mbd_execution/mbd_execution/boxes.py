"""Boxes as a hand sees them: long or not, which way they lie, how one compares with another."""

from __future__ import annotations

import math

from mbd_model.objects import SceneObject

from mbd_execution.goals import turn_between, turned

# A box counts as long from this ratio of its sides on; below, perception cannot find out which way it lies.
LONG = 1.2
# [m] Sideways offsets smaller than this were not meant: the tremble of a guided hand and the noise of perception.
MEANT = 0.015


def top(box: SceneObject) -> float:
    """Height of its top [m]."""
    return box.centroid[2] + box.size[2] / 2


def bottom(box: SceneObject) -> float:
    """Height of its bottom [m]."""
    return box.centroid[2] - box.size[2] / 2


def sides(box: SceneObject) -> tuple[float, float]:
    """(longer, shorter) horizontal side [m]."""
    return max(box.size[:2]), min(box.size[:2])


def is_long(box: SceneObject) -> bool:
    """Whether one horizontal side is clearly longer than the other."""
    longer, shorter = sides(box)
    return longer >= LONG * shorter


def long_axis(box: SceneObject) -> float:
    """Direction of its longer side [rad], which means the same after half a turn."""
    width, depth, _ = box.size
    return box.yaw if depth >= width else box.yaw + math.pi / 2


def turn_of_frame(source: SceneObject, target: SceneObject) -> float:
    """By how much [rad] directions turn from one box to the one that plays its part.

    Two long boxes: from one long axis to the other, the shorter way. Otherwise the boxes do not show it, and directions
    stay as they are in the robot's frame.
    """
    if is_long(source) and is_long(target):
        return turn_between(long_axis(source), long_axis(target), math.pi)
    return 0.0


def adapted_offset(
    offset: tuple[float, float], source: SceneObject, target: SceneObject
) -> tuple[float, float]:  # fmt: skip
    """A horizontal offset (x, y) [m] from the middle of a source box as it is on the target box.

    It keeps its share of each side: what was set down at the edge of a box is set down at the edge of a smaller one.
    """
    axis = long_axis(source) if is_long(source) and is_long(target) else 0.0
    along, across = turned(*offset, -axis)
    if axis or (is_long(source) and is_long(target)):
        scale = tuple(t / s for s, t in zip(sides(source), sides(target), strict=True))
    else:
        mean = sum(sides(target)) / sum(sides(source))
        scale = (mean, mean)
    along = along * scale[0] if abs(along) >= MEANT else 0.0
    across = across * scale[1] if abs(across) >= MEANT else 0.0
    return turned(along, across, axis + turn_of_frame(source, target))
