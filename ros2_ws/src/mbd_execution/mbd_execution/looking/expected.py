"""What a look at the table should show if everything stands where it is believed to."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.geometry.boxes import distance_to_footprint
from mbd_model.objects import SceneObject

from mbd_execution.boxes import bottom, sides, top

STANDS = 0.008  # [m] by which an object that nobody moved is seen elsewhere: perception's noise
SETTLES = 0.02  # [m] the same of one that the robot set down, or that stands on another
HIDES = 0.005  # [m] what reaches so far down into another one is in it, and may be seen as one with it
OUTLINE = 0.15  # share by which the sides of a covered one may differ for its outline to be seen whole
TOUCHES = 0.012  # [m] between two boxes that stand as near as this one object may be seen in place of two


@dataclass(frozen=True)
class Expected:
    """An object that is believed to be on the table.

    Attributes:
        object: as it is believed to stand; ``centroid`` is the middle of its box.
        spread: [m] standard deviation of where it is seen, when nobody touches it.
        covered: something stands on or in it, so that its sides and its color are seen in part, or not at all.
        supported: it stands on or in another one, so that its sides and its color may be taken together with that.
        hidden: it need not show by itself: it is in another one, or another one covers it.
        lying: it lay on its side in the last look; ``object`` is how it would stand there.
        others: (x, y) [m] of the other objects, with any of which it may change places.
    """

    object: SceneObject
    spread: float = STANDS
    covered: bool = False
    hidden: bool = False
    supported: bool = False
    lying: bool = False
    others: tuple[tuple[float, float], ...] = ()


def expectations(
    table: TrackedObjects, absent: frozenset[str] = frozenset(), lying: frozenset[str] = frozenset()
) -> tuple[Expected, ...]:
    """What should show of the believed objects.

    Args:
        table: where they are believed to be, and what stands on what.
        absent: ids of those that are not on the table: the one in the hand, and those that vanished before.
        lying: ids of those that the last look showed lying, on the table as they would stand.
    """
    support = dict(table.rests_on)
    there = [o for o in table.objects if o.object_id not in absent]
    ids = {o.object_id for o in there}
    loaded = {lower for upper, lower in support.items() if upper in ids}

    def hidden(thing: SceneObject) -> bool:
        below = support.get(thing.object_id)
        inside = below is not None and below in ids and _in(thing, table[below])
        return inside or thing.object_id in loaded or _beside_in_box(thing, there, support)

    def others(thing: SceneObject) -> tuple[tuple[float, float], ...]:
        return tuple((o.centroid[0], o.centroid[1]) for o in there if o is not thing and o.object_id not in support)

    return tuple(
        Expected(
            o,
            spread=SETTLES if o.object_id in support else STANDS,
            covered=o.object_id in loaded,
            hidden=hidden(o),
            supported=o.object_id in support,
            lying=o.object_id in lying,
            others=others(o),
        )
        for o in there
    )


def stood_up(table: TrackedObjects, lying: frozenset[str], upright: TrackedObjects) -> TrackedObjects:
    """The table with what lay as it would stand, so that the next look says whether it still lies.

    Args:
        table: as it is believed to be.
        lying: ids of those that the last look showed lying.
        upright: the objects as they stood when they were first seen.
    """
    known = {o.object_id: o for o in upright.objects}
    there = {o.object_id: o for o in table.objects}
    for name in sorted(lying & known.keys() & there.keys()):
        lies = there[name]
        x, y, _ = lies.centroid
        there[name] = replace(known[name], centroid=(x, y, bottom(lies) + known[name].size[2] / 2))
        for upper in table.load(name) - {name}:
            x, y, z = there[upper].centroid
            there[upper] = replace(there[upper], centroid=(x, y, z + top(there[name]) - top(lies)))
    return replace(table, objects=tuple(there[o.object_id] for o in table.objects))


def _in(thing: SceneObject, other: SceneObject) -> bool:
    """Whether it is in another one, and not only on it."""
    return bottom(thing) < top(other) - HIDES and sides(thing)[1] < sides(other)[1]


def _beside_in_box(thing: SceneObject, others: list[SceneObject], support: dict[str, str]) -> bool:
    """Whether it stands in the same box as a neighbour that touches it: the two may be seen as one."""
    below = support.get(thing.object_id)
    if below is None:
        return False
    return any(
        support.get(o.object_id) == below
        and o.object_id != thing.object_id
        and distance_to_footprint(thing.centroid, o) - sides(thing)[1] / 2 < TOUCHES
        for o in others
    )


def seen_box(thing: SceneObject) -> SceneObject:
    """An object of a scene as execution takes it: the middle of its box is its place."""
    return replace(thing, centroid=thing.box_center or thing.centroid)


def outline_whole(believed: SceneObject, seen: SceneObject) -> bool:
    """Whether what is seen is as long and as wide as the object: neither a part of it, nor it and another one."""
    return all(abs(b - a) < OUTLINE * a for a, b in zip(sides(believed), sides(seen), strict=True))


def as_it_stands(expected: Expected, seen: SceneObject) -> SceneObject | None:
    """The believed object at the place where it is seen; None when what is seen of it does not say where it is.

    What stands on something is seen as high as its top is above the table, so its height stays the believed one and its
    top is the seen one. Of a covered one only a whole outline says where it is.
    """
    believed = expected.object
    if not expected.covered:
        height = max(top(seen) - believed.size[2] / 2, believed.size[2] / 2 + min(bottom(seen), bottom(believed)))
        return replace(believed, centroid=(seen.centroid[0], seen.centroid[1], height), yaw=seen.yaw)
    if not outline_whole(believed, seen):
        return None
    return replace(believed, centroid=(seen.centroid[0], seen.centroid[1], believed.centroid[2]))
