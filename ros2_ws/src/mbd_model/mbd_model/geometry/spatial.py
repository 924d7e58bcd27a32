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


def relations_between(i: SceneObject, j: SceneObject) -> tuple[Relation, ...]:
    """Where ``i`` lies relative to ``j``: none when they overlap in x and in y, two when they are apart in both.

    Both count: with one label a pair, the study's figures (../shared/hri17/expected.csv) do not come out.
    """
    i_near, i_far, i_right, i_left = extents(i)
    j_near, j_far, j_right, j_left = extents(j)
    holds = (
        (Relation.LEFT_OF, i_right > j_left),
        (Relation.RIGHT_OF, i_left < j_right),
        (Relation.ABOVE, i_near > j_far),
        (Relation.BELOW, i_far < j_near),
    )
    return tuple(relation for relation, true in holds if true)


def spatial_relations(objects: Sequence[SceneObject]) -> tuple[tuple[tuple[Relation, str], ...], ...]:
    """For each object its (relation, other object's id), at most two for each other object, in the order given."""
    return tuple(
        tuple(
            (relation, other.object_id)
            for other in objects
            if other.object_id != obj.object_id
            for relation in relations_between(obj, other)
        )
        for obj in objects
    )
