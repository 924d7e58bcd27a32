"""Objects seen again keep their names: perception numbers them by their order, which may change by a hair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mbd_model.objects import Scene
from scipy.optimize import linear_sum_assignment

SAME_PLACE = 0.05  # [m] in the plane of the table: less than half of what lies between two objects


def named_as(recorded: Scene, computed: Scene) -> Scene:
    """The computed scene with the ids and the order of the recorded one, each object's by where it stands.

    A scene with another number of objects, or one that is nowhere near where it was, is left as it is.

    Args:
        recorded: as published.
        computed: of the same frames.
    """
    if len(recorded.objects) != len(computed.objects) or not recorded.objects:
        return computed
    old, new = (np.array([o.centroid[:2] for o in scene.objects]) for scene in (recorded, computed))
    distances = np.linalg.norm(old[:, None] - new[None], axis=2)
    rows, columns = linear_sum_assignment(distances)
    if distances[rows, columns].max() > SAME_PLACE:
        return computed
    chosen = [computed.objects[int(column)] for column in columns]
    names = {o.object_id: name for o, name in zip(chosen, recorded.ids, strict=True)}
    place = {name: number for number, name in enumerate(recorded.ids)}
    objects = []
    for thing in chosen:
        relations = ((kind, names.get(other, other)) for kind, other in thing.relations)
        ordered = sorted(relations, key=lambda relation: place.get(relation[1], len(place)))
        objects.append(replace(thing, object_id=names[thing.object_id], relations=tuple(ordered)))
    return replace(computed, objects=tuple(objects))
