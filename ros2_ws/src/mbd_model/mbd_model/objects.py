"""Objects as the method compares them, and the scenes they stand in (paper sec. 4.1, Table 1)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

from mbd_model.errors import MbdError


class Relation(IntEnum):
    """Where an object lies relative to another, seen by the robot; values equal mbd_msgs/SpatialRelation."""

    LEFT_OF = 1
    RIGHT_OF = 2
    ABOVE = 3
    BELOW = 4


class Role(StrEnum):
    """Which part a scene plays in the transfer."""

    SOURCE = "source"
    TARGET = "target"


@dataclass(frozen=True)
class FeatureDeviations:
    """Standard deviations of an object's measured features: how far each may be from the truth.

    Attributes:
        centroid: along x, y, z [m, frame of the scene], of the mean of the points that can be seen.
        box_center: along x, y, z [m, frame of the scene], of the middle of the complete object, hidden parts included.
        size: of width, depth and height [m] of the complete object.
        yaw: [rad].
        volume: [m^3].
        hue: [deg]; None when the object has no hue.
        saturation: 0..1.
    """

    centroid: tuple[float, float, float]
    box_center: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float
    volume: float
    hue: float | None
    saturation: float

    def __post_init__(self) -> None:
        """Validate once; raises MbdError naming the feature."""
        single = (("yaw", self.yaw), ("volume", self.volume), ("hue", self.hue or 0.0), ("saturation", self.saturation))
        triples = (("centroid", self.centroid), ("box_center", self.box_center), ("size", self.size))
        values = [(name, (value,)) for name, value in single] + [(name, tuple(value)) for name, value in triples]
        for name, numbers in values:
            if not all(math.isfinite(v) and v >= 0.0 for v in numbers):
                raise MbdError(f"standard deviation of {name} is {numbers}: expected finite numbers, none below 0")
        if any(len(value) != 3 for _, value in triples):
            raise MbdError("standard deviations of centroid, box_center and size are three numbers each")


@dataclass(frozen=True)
class SceneObject:
    """One object on the table with every feature the mapping compares: <x, y, z, c, d, s, a, p> of paper sec. 4.1.

    Attributes:
        object_id: unique in its scene, not empty.
        centroid: (x, y, z) [m], robot base frame.
        size: (width, depth, height) [m] of its bounding box: width along y, depth along x, height along z when
            ``yaw`` is 0.
        yaw: rotation of the box about z [rad], robot base frame.
        hue: circular mean hue [deg, 0..360), None when the object is too grey to have one.
        saturation: mean HSV saturation, 0..1.
        color_name: a word for people ("red"); "" when unknown.
        object_class: class of the knowledge base, "unknown" when none fits.
        class_score: how well that class fits, 0..1.
        affordances, properties: looked up by class (Tables 2 and 4).
        relations: (relation, other object's id), at most two for each other object: one sideways, one near or far.
        volume: bounding-box volume d [m^3]; computed from ``size`` unless given.
        box_center: (x, y, z) middle of the bounding box [m, robot base frame], which the mean of the visible points
            (``centroid``) is not; None when nobody measured it.
        deviations: how exactly each feature was measured; None when nobody knows.
    """

    object_id: str
    centroid: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float = 0.0
    hue: float | None = None
    saturation: float = 0.0
    color_name: str = ""
    object_class: str = "unknown"
    class_score: float = 0.0
    affordances: frozenset[str] = frozenset()
    properties: frozenset[str] = frozenset()
    relations: tuple[tuple[Relation, str], ...] = ()
    volume: float = field(default=math.nan)
    box_center: tuple[float, float, float] | None = None
    deviations: FeatureDeviations | None = None

    def __post_init__(self) -> None:
        """Validate once; raises MbdError naming the object and the field."""
        if not self.object_id:
            raise MbdError("an object needs an id: got the empty string; give each object of a scene its own name")
        if len(self.centroid) != 3 or not all(math.isfinite(v) for v in self.centroid):
            raise MbdError(f"object '{self.object_id}': centroid {self.centroid} is not three finite numbers [m]")
        if len(self.size) != 3 or not all(math.isfinite(v) and v > 0 for v in self.size):
            raise MbdError(f"object '{self.object_id}': size {self.size} is not three positive numbers [m]")
        if self.hue is not None and not 0.0 <= self.hue < 360.0:
            raise MbdError(f"object '{self.object_id}': hue {self.hue} is outside [0, 360) deg; use None for 'no hue'")
        if math.isnan(self.volume):
            object.__setattr__(self, "volume", self.size[0] * self.size[1] * self.size[2])
        if not (math.isfinite(self.volume) and self.volume > 0):
            raise MbdError(f"object '{self.object_id}': volume {self.volume} is not a positive number [m^3]")


@dataclass(frozen=True)
class Scene:
    """The objects of one observation.

    Attributes:
        role: source (demonstrated on) or target (carried over to).
        objects: in the order observed, ids unique.
        stamp: time of the observation [s].
        frame_id: the frame of every coordinate in it.
    """

    role: Role
    objects: tuple[SceneObject, ...]
    stamp: float = 0.0
    frame_id: str = "j2n6s300_link_base"

    def __post_init__(self) -> None:
        """Validate once; raises MbdError when two objects share an id."""
        ids = [o.object_id for o in self.objects]
        twice = sorted({i for i in ids if ids.count(i) > 1})
        if twice:
            raise MbdError(f"{self.role} scene: ids {twice} name several objects; ids must be unique in a scene")

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids in scene order."""
        return tuple(o.object_id for o in self.objects)

    def __getitem__(self, object_id: str) -> SceneObject:
        """The object of that id; raises MbdError listing the ids there are."""
        for candidate in self.objects:
            if candidate.object_id == object_id:
                return candidate
        raise MbdError(f"no object '{object_id}' in the {self.role} scene; it has {sorted(self.ids)}")

    def subset(self, ids: Iterable[str]) -> tuple[SceneObject, ...]:
        """The objects of these ids, in that order; raises MbdError for an id that is not here."""
        return tuple(self[i] for i in ids)
