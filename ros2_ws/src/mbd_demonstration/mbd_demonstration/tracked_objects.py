"""Where the objects are now: the source scene, followed through what the demonstration moved (paper sec. 6.5.1)."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from mbd_model.geometry.boxes import distance_to_footprint, nearest
from mbd_model.objects import Scene, SceneObject
from numpy.typing import NDArray

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.geometry.supports import Support, bottom_of, standing_on, support, top_of
from mbd_demonstration.trajectory import ToolPose


@dataclasses.dataclass(frozen=True)
class TrackedObjects:
    """The objects at one moment of the demonstration.

    Attributes:
        objects: in scene order, each where it now is.
        table: height of what the lowest object stood on before [m, robot base frame]; -inf: not known.
        rests_on: (object, what it stands on or in) for each that stood so before, or that the demonstration put there.
    """

    objects: tuple[SceneObject, ...]
    rests_on: tuple[tuple[str, str], ...] = ()
    table: float = -math.inf

    @classmethod
    def before(cls, scene: Scene) -> TrackedObjects:
        """Everything where the source scene saw it, and what stood on what there."""
        table = min((bottom_of(o) for o in scene.objects), default=-math.inf)
        return cls(scene.objects, standing_on(scene.objects, 0.0), table)

    def __getitem__(self, object_id: str) -> SceneObject:
        """The object of that id; raises KeyError when there is none."""
        for obj in self.objects:
            if obj.object_id == object_id:
                return obj
        raise KeyError(object_id)

    def by_distance(self, point: NDArray[np.float64], without: frozenset[str] = frozenset()) -> list[tuple[float, str]]:
        """(surface distance [m], id) of each object, nearest to a point (3,) [m, robot base frame] first."""
        candidates = tuple(o for o in self.objects if o.object_id not in without)
        return [(distance, obj.object_id) for distance, obj in nearest(point, candidates)]

    def load(self, object_id: str) -> frozenset[str]:
        """The object and everything that stands on or in it: what moves when it is moved."""
        moved = {object_id}
        while True:
            more = {upper for upper, lower in self.rests_on if lower in moved} - moved
            if not more:
                return frozenset(moved)
            moved |= more

    def carried(self, object_id: str, grasp: ToolPose, release: ToolPose) -> TrackedObjects:
        """The workspace after the tool carried an object, and what stood on it, from one pose to another.

        The object moves rigidly with the tool. Of its rotation the box keeps what is about z: it stands again.
        """
        turn = _rotation(release.quaternion) @ _rotation(grasp.quaternion).T
        yaw = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
        moved = self.load(object_id)

        def after(obj: SceneObject) -> SceneObject:
            if obj.object_id not in moved:
                return obj
            x, y, z = release.position + turn @ (np.asarray(obj.centroid) - grasp.position)
            return dataclasses.replace(
                obj, centroid=(float(x), float(y), float(z)), yaw=math.remainder(obj.yaw + yaw, 2 * math.pi)
            )

        rests_on = tuple((upper, lower) for upper, lower in self.rests_on if upper != object_id)
        return dataclasses.replace(self, objects=tuple(after(o) for o in self.objects), rests_on=rests_on)

    def put_onto(self, object_id: str, receiver: str) -> TrackedObjects:
        """The workspace knowing that one object now rests on another."""
        return dataclasses.replace(self, rests_on=(*self.rests_on, (object_id, receiver)))

    def receivers(self, object_id: str, config: StepSegmentationConfig) -> frozenset[str]:
        """The objects that one may have been put onto or into, now that it was let go (see ``supports``)."""
        held, moved = self[object_id], self.load(object_id)
        return frozenset(
            obj.object_id
            for obj in self.objects
            if obj.object_id not in moved
            and support(held, obj, config.onto_margin, config.onto_clearance) is not Support.NONE
        )

    def fall(self, object_id: str, margin: float) -> float:
        """How far the bottom of an object is above the highest thing that is below it [m]: the table, or another.

        The table is at the lowest bottom of all the others; an object alone stands on it where it was first seen.
        ``margin`` [m] widens their footprints.
        """
        held, moved = self[object_id], self.load(object_id)
        others = [o for o in self.objects if o.object_id not in moved]
        tops = [top_of(o) for o in others if distance_to_footprint(held.centroid, o) <= margin]
        return bottom_of(held) - max([self.table, *tops])


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix (3, 3) of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
