"""What a look shows to have changed on the table, and where everything is believed to be after it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.geometry.boxes import distance_to_footprint
from mbd_model.objects import Scene, SceneObject

from mbd_execution.boxes import bottom, top
from mbd_execution.looking.expected import Expected, as_it_stands, expectations, seen_box
from mbd_execution.looking.identities import Identities, Identity, identify
from mbd_execution.looking.likeness import color, shape
from mbd_execution.looking.piles import PART, SURE, by_piles

MOVED = 0.02  # [m] from here on somebody moved it
APART = 0.03  # [m] an object is not taken for another one that is nearer than this
NEWCOMER = "new"  # prefix of the id of an object nobody knows


class TableChange(StrEnum):
    """What can have happened to an object."""

    MOVED = "moved"
    GONE = "gone"
    FALLEN = "fallen over"
    SWAPPED = "changed places"
    UNSURE = "may be another one"
    NEW = "new"


@dataclass(frozen=True)
class TableDifference:
    """One thing that changed.

    Attributes:
        change: what.
        object_id: of the believed object, or the id a new one was given.
        other: the believed object it changed places with, or may be taken for; "" for none.
        otherwise: where everything is in the next best assignment; None unless there are two to choose from.
    """

    change: TableChange
    object_id: str
    other: str = ""
    otherwise: TrackedObjects | None = None


@dataclass(frozen=True)
class Looked:
    """What a look says.

    Attributes:
        table: where everything is believed to be now: what moved, moved; what is gone stays where it was, and is
            listed in ``gone``; what is new is on it, under an id of its own.
        differences: what changed.
        gone: ids of believed objects that are not there.
        new: ids of objects nobody knows.
    """

    table: TrackedObjects
    differences: tuple[TableDifference, ...]
    gone: frozenset[str]
    new: frozenset[str]

    def of(self, change: TableChange, object_id: str = "") -> tuple[TableDifference, ...]:
        """The differences of that kind, of one object or of all."""
        return tuple(d for d in self.differences if d.change is change and object_id in ("", d.object_id))


def look(table: TrackedObjects, scene: Scene, in_hand: str = "", lying: frozenset[str] = frozenset()) -> Looked:
    """Compare a look with what is believed.

    Args:
        table: where everything is believed to be; objects whose id begins with ``NEWCOMER`` were new once.
        scene: the look; its ids mean nothing.
        in_hand: id of the object in the hand, which is not on the table.
        lying: ids of those that the last look showed lying, on the table as they would stand.
    """
    seen = tuple(seen_box(o) for o in scene.objects)
    expected = expectations(table, frozenset({in_hand} if in_hand else ()), lying)
    found = by_piles(table, identify(expected, seen), seen)
    after, gone = _moved(table, found, seen)
    differences = [_difference(table, identity, found, seen, gone) for identity in found.known]
    newcomers = _newcomers(after, found, seen, gone)
    numbers = (f"{NEWCOMER}{n}" for n in range(1, len(table.objects) + len(seen) + 2))
    free = (n for n in numbers if n not in {o.object_id for o in table.objects})
    named = tuple(replace(o, object_id=next(free)) for o in newcomers)
    kept = tuple(o for o in after.objects if not (o.object_id in gone and o.object_id.startswith(NEWCOMER)))
    news = [TableDifference(TableChange.NEW, o.object_id, _like(o, table)) for o in named]
    return Looked(
        replace(after, objects=(*kept, *named)),
        (*(d for d in differences if d is not None), *news),
        gone,
        frozenset(o.object_id for o in named),
    )


def _difference(
    table: TrackedObjects, identity: Identity, found: Identities, seen: Sequence[SceneObject], gone: frozenset[str]
) -> TableDifference | None:
    name = identity.expected.object.object_id
    if name.startswith(NEWCOMER):
        return None
    if name in gone:
        return TableDifference(TableChange.GONE, name)
    if identity.piled is not None and math.hypot(*identity.piled) > 0.0:
        return TableDifference(TableChange.MOVED, name)
    if identity.seen is None:
        return None
    if identity.fallen:
        return TableDifference(TableChange.FALLEN, name)
    now = seen[identity.seen]
    apart = math.dist(now.centroid[:2], identity.expected.object.centroid[:2])
    if identity.expected.hidden:
        return None  # it shows in part or not at all: too little to tell more
    if apart > APART:
        other = _at(now, [k for k in found.known if k is not identity])
        if other is not None:
            twins = identity.margin < SURE or _alike(other.expected.object, now)
            otherwise = None
            if twins and other.seen is not None:
                otherwise = _exchanged(table, found, seen, identity, other.seen)
            return TableDifference(TableChange.SWAPPED, name, other.expected.object.object_id, otherwise)
    if identity.margin < SURE:
        if identity.otherwise is None:
            return TableDifference(TableChange.UNSURE, name)
        if math.dist(now.centroid[:2], seen[identity.otherwise].centroid[:2]) > APART:
            otherwise = _exchanged(table, found, seen, identity, identity.otherwise)
            return TableDifference(TableChange.UNSURE, name, _taken_by(found, identity.otherwise), otherwise)
    return TableDifference(TableChange.MOVED, name) if apart > MOVED else None


def _moved(
    table: TrackedObjects, found: Identities, seen: Sequence[SceneObject]
) -> tuple[TrackedObjects, frozenset[str]]:  # fmt: skip
    """The table with everything where it is seen, and what is gone.

    What does not show moves with what holds it, and what is covered with what stands on it.
    """
    places: dict[str, SceneObject] = {}
    for known in found.known:
        if known.seen is not None:
            thing, now = known.expected.object, seen[known.seen]
            place = replace(now, object_id=thing.object_id) if known.fallen else as_it_stands(known.expected, now)
            if place is not None:
                places[thing.object_id] = place
        elif known.piled is not None:
            x, y, z = known.expected.object.centroid
            there = (x + known.piled[0], y + known.piled[1], z)
            places[known.expected.object.object_id] = replace(known.expected.object, centroid=there)
    gone = frozenset(
        k.expected.object.object_id for k in found.known if k.seen is None and k.piled is None and not k.expected.hidden
    )
    fallen = {k.expected.object.object_id for k in found.known if k.fallen}
    pairs = [pair for pair in table.rests_on if not fallen & set(pair)]
    up = [(lower, upper) for upper, lower in pairs]
    # One that is a little beside where it was put came to rest there, or slid: what is under it was not touched.
    down = [pair for pair in reversed(pairs) if pair[0] not in places or _far(places[pair[0]], table[pair[0]])]
    for one, other in (*up, *down):
        together = one in places and _still_on(places[one], table[one])
        if together and other not in places and other not in gone:
            (x0, y0, _), (x1, y1, _) = table[one].centroid, places[one].centroid
            x, y, z = table[other].centroid
            places[other] = replace(table[other], centroid=(x + x1 - x0, y + y1 - y0, z))
    # What lies apart from what it stood on stands on it no more.
    objects = tuple(places.get(o.object_id, o) for o in table.objects)
    where = {o.object_id: o for o in objects}
    rests = tuple(
        (upper, lower)
        for upper, lower in table.rests_on
        if upper not in gone and distance_to_footprint(where[upper].centroid, where[lower]) < APART
    )
    return replace(table, objects=objects, rests_on=rests), gone


def _far(now: SceneObject, before: SceneObject) -> bool:
    return math.dist(now.centroid[:2], before.centroid[:2]) > APART


def _still_on(now: SceneObject, before: SceneObject) -> bool:
    """Whether an object is as high as it was: then what stood together moved together."""
    return abs(bottom(now) - bottom(before)) < APART


def _exchanged(
    table: TrackedObjects, found: Identities, seen: Sequence[SceneObject], identity: Identity, otherwise: int
) -> TrackedObjects:
    """The table if this object is where the next best assignment has it, and whoever is there is where this one is."""
    known = []
    for other in found.known:
        if other is identity:
            known.append(replace(other, seen=otherwise))
        elif other.seen == otherwise:
            known.append(replace(other, seen=identity.seen))
        else:
            known.append(other)
    return _moved(table, replace(found, known=tuple(known)), seen)[0]


def _at(now: SceneObject, others: Sequence[Identity]) -> Identity | None:
    """The believed object at whose place another one is seen now."""
    near = [(math.dist(now.centroid[:2], k.expected.object.centroid[:2]), k) for k in others if not k.expected.hidden]
    best = min(near, key=lambda pair: pair[0], default=None)
    return best[1] if best is not None and best[0] < MOVED else None


def _alike(believed: SceneObject, seen: SceneObject) -> bool:
    """Whether one may be taken for the other by its looks: another color is enough to tell them apart."""
    by_color = color(Expected(believed, 0.0), seen)
    return by_color > 0.0 and shape(Expected(believed, 0.0), seen) + by_color > 0.0


def _taken_by(found: Identities, index: int) -> str:
    """Id of the believed object that was taken for the seen one of that index, "" for none."""
    return next((k.expected.object.object_id for k in found.known if k.seen == index), "")


def _newcomers(
    table: TrackedObjects, found: Identities, seen: Sequence[SceneObject], gone: frozenset[str]
) -> tuple[SceneObject, ...]:
    """The objects seen that are no believed one and no part of one that is there."""
    there = [o for o in table.objects if o.object_id not in gone]

    def part(thing: SceneObject) -> bool:
        return any(distance_to_footprint(thing.centroid, o) < PART and top(thing) < top(o) + PART for o in there)

    return tuple(seen[i] for i in found.new if not part(seen[i]))


def _like(newcomer: SceneObject, table: TrackedObjects) -> str:
    """Id of the believed object it could be taken for by its looks, "" for none."""
    alike = [o for o in table.objects if _alike(o, newcomer)]
    best = max(alike, key=lambda o: shape(Expected(o, 0.0), newcomer) + color(Expected(o, 0.0), newcomer), default=None)
    return best.object_id if best is not None else ""
