"""Spatial relations between objects, from extents rather than centroids (paper sec. 4.1; ../shared/hri17/README.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbd_model.objects import Relation, SceneObject


def extents(obj: SceneObject) -> tuple[float, float, float, float]:
    """(near, far, right, left) edges of the turned box [m, robot base frame]: its min x, max x, min y, max y."""
    width, depth, _ = obj.size
    cos, sin = abs(math.cos(obj.yaw)), abs(math.sin(obj.yaw))
    half_x = 0.5 * (depth * cos + width * sin)
    half_y = 0.5 * (width * cos + depth * sin)
    x, y, _ = obj.centroid
    return x - half_x, x + half_x, y - half_y, y + half_y


def relation_between(i: SceneObject, j: SceneObject) -> Relation | None:
    """Where ``i`` lies relative to ``j``; None when they overlap in x and in y.

    Sideways comes first: an object that is both left of and above another is LEFT_OF it, as in the study's program.
    """
    i_near, i_far, i_right, i_left = extents(i)
    j_near, j_far, j_right, j_left = extents(j)
    if i_right > j_left:
        return Relation.LEFT_OF
    if i_left < j_right:
        return Relation.RIGHT_OF
    if i_near > j_far:
        return Relation.ABOVE
    if i_far < j_near:
        return Relation.BELOW
    return None


def spatial_relations(objects: Sequence[SceneObject]) -> tuple[tuple[tuple[Relation, str], ...], ...]:
    """For each object its (relation, other object's id), at most one for each other object, in the order given."""
    return tuple(
        tuple(
            (relation, other.object_id)
            for other in objects
            if other.object_id != obj.object_id and (relation := relation_between(obj, other)) is not None
        )
        for obj in objects
    )
