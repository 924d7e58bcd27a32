"""Is a mapping right? Only a simulated cell knows: its truth names objects, perception's scenes have ids."""

from __future__ import annotations

from collections.abc import Mapping as MappingType
from collections.abc import Sequence

import numpy as np
from mbd_bag.session.recorded_session import Recorded, RecordedSession, TrueObject, Truth
from mbd_model.estimate import Mapping, MappingEstimate
from mbd_model.objects import Role, Scene
from mbd_model.times import to_nanoseconds
from scipy.optimize import linear_sum_assignment

# A perceived centroid is that of the visible surface: off the true centre by up to about half an object.
MATCH_DISTANCE = 0.08  # [m] in the plane of the table


def match_names(scene: Scene, objects: Sequence[TrueObject], limit: float = MATCH_DISTANCE) -> dict[str, str]:
    """True names by perceived id, by the assignment with the least sum of distances in the plane of the table.

    Args:
        scene: as perceived.
        objects: as they are.
        limit: pairs farther apart than this are no match [m].
    """
    if not scene.objects or not objects:
        return {}
    perceived = np.array([o.centroid[:2] for o in scene.objects])
    true = np.array([o.centroid[:2] for o in objects])
    distances = np.linalg.norm(perceived[:, None] - true[None], axis=2)
    rows, columns = linear_sum_assignment(np.minimum(distances, 10 * limit))
    return {
        scene.objects[int(row)].object_id: objects[int(column)].name
        for row, column in zip(rows, columns, strict=True)
        if distances[row, column] <= limit
    }


def truth_at(truths: Sequence[Recorded[Truth]], role: Role, stamp: int) -> Truth | None:
    """The table's truth when a scene was seen: the latest of that role up to ``stamp`` [ns], else its first."""
    of_role = [t for t in truths if t.value.role is role and t.value.objects]
    before = [t for t in of_role if t.stamp <= stamp]
    if before:
        return before[-1].value
    return of_role[0].value if of_role else None


class Answers:
    """Which target objects are right for each source object of a session, by perceived ids.

    Attributes:
        source_names, target_names: true names by perceived id.
        right: acceptable target names by source name.
    """

    def __init__(self, source_names: MappingType[str, str], target_names: MappingType[str, str], truth: Truth) -> None:
        self.source_names = source_names
        self.target_names = target_names
        self.right = truth.solution

    def is_right(self, source_id: str, target_id: str) -> bool:
        """Whether this target object may play the role of this source object."""
        name = self.source_names.get(source_id, "")
        return self.target_names.get(target_id, "") in self.right.get(name, frozenset())

    def correct(self, estimate: MappingEstimate, used: Sequence[str]) -> bool:
        """Whether the estimate maps every object the task uses to a right target.

        Args:
            estimate: as made.
            used: source ids that the task's steps name.
        """
        return self.maps_right(estimate.mapping, used)

    def maps_right(self, mapping: Mapping, used: Sequence[str]) -> bool:
        """Whether a mapping, as one of an estimate's readings, gives every source id in ``used`` a right target."""
        pairs = mapping.as_dict
        return bool(used) and all(self.is_right(source, pairs.get(source, "")) for source in used)


def answers_of(session: RecordedSession) -> Answers | None:
    """The right answers of a session; None when its bag holds no truth, task or target scene."""
    if not session.tasks or not session.target_scenes:
        return None
    source = session.tasks[-1].value.source
    target = session.target_scenes[-1]
    source_stamp = next((s.stamp for s in session.source_scenes if s.value == source), to_nanoseconds(source.stamp))
    source_truth = truth_at(session.truths, Role.SOURCE, source_stamp)
    target_truth = truth_at(session.truths, Role.TARGET, target.stamp)
    if source_truth is None or target_truth is None:
        return None
    solution = target_truth if target_truth.solution else source_truth
    return Answers(match_names(source, source_truth.objects), match_names(target.value, target_truth.objects), solution)
