"""Which perceived object is which true one: the scripted wizard's eyes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.objects import Role, Scene
from scipy.optimize import linear_sum_assignment

MAX_DISTANCE = 0.05  # between a perceived centroid and the true centre, horizontally [m]


@dataclass(frozen=True)
class TrueTable:
    """What stands on the table.

    Attributes:
        places: name -> (x, y) of its centre [m, robot base frame].
        solution: source name -> target names that are right for it, in order of preference.
    """

    places: Mapping[str, tuple[float, float]]
    solution: Mapping[str, Sequence[str]]


def recognise(scene: Scene, places: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """Perceived id -> true name, the nearest ones together, none farther apart than MAX_DISTANCE."""
    names = list(places)
    if not scene.objects or not names:
        return {}
    cost = np.array([[math.dist(o.centroid[:2], places[name]) for name in names] for o in scene.objects])
    rows, columns = linear_sum_assignment(np.minimum(cost, 2 * MAX_DISTANCE))
    return {
        scene.objects[i].object_id: names[j] for i, j in zip(rows, columns, strict=True) if cost[i, j] <= MAX_DISTANCE
    }


def is_right(
    source_id: str, target_id: str, names: Mapping[Role, Mapping[str, str]], solution: Mapping[str, Sequence[str]]
) -> bool:
    """Whether a perceived target object is a right answer for a perceived source object, as the cell knows it.

    Args:
        source_id: perceived id of the source object.
        target_id: perceived id of the target object.
        names: perceived id -> true name, of either scene.
        solution: source name -> target names.
    """
    right = solution.get(names[Role.SOURCE].get(source_id, ""), ())
    return names[Role.TARGET].get(target_id) in right


def right_target(
    source_id: str,
    names: Mapping[Role, Mapping[str, str]],
    solution: Mapping[str, Sequence[str]],
    *,
    used: Sequence[str],
    wrong: bool = False,
) -> str | None:
    """Perceived id of a target object that is right (or, on purpose, wrong) for a perceived source object.

    Args:
        source_id: perceived id of the source object asked about.
        names: perceived id -> true name, of either scene.
        solution: source name -> target names, preferred first.
        used: perceived target ids that earlier assists took.
        wrong: give one that is not right.

    Returns:
        The id; None when the source object was not recognised or nothing suitable is left.
    """
    name = names[Role.SOURCE].get(source_id)
    if name is None:
        return None
    id_of = {true: perceived for perceived, true in names[Role.TARGET].items()}
    right = list(solution.get(name, ()))
    wanted = [n for n in names[Role.TARGET].values() if n not in right] if wrong else right
    free = [id_of[n] for n in wanted if n in id_of and id_of[n] not in used]
    return free[0] if free else None
