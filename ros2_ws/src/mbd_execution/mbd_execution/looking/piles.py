"""Piles: objects that stand on or in each other, which a look may show as one, or in pieces.

A camera that looks at a tower of cups, or at a fork across a bowl, sees surfaces that touch: perception returns one
object for several, or a piece of one as an object. Then no assignment of objects to objects fits. What still says
something is how high the pile reaches, and where it is: it reaches as high as it should only if everything is on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.geometry.boxes import distance_to_footprint
from mbd_model.objects import SceneObject
from numpy.typing import NDArray

from mbd_execution.boxes import bottom, top
from mbd_execution.looking.expected import HIDES, outline_whole
from mbd_execution.looking.identities import Identities, Identity

SURE = 5.0  # [nats] by which one assignment must be better than the next, not to be asked about
PART = 0.02  # [m] beside a believed object, what is seen no higher than it may be a part of it
TELLS = 0.01  # [m] by which the tops with and without an object must differ for the seen top to say which
LIES_DEEP = 0.02  # [m] the same of one that is in another: how deep it came to rest is not known
GROWN = 0.03  # [m] by which a pile may be seen to reach beyond where it should: more, and something slid off it
SHIFTED = 0.02  # [m] from here on somebody moved the pile


def by_piles(table: TrackedObjects, found: Identities, seen: Sequence[SceneObject]) -> Identities:
    """The identities, those of objects in a pile that is not seen object by object by what the pile shows as a whole.

    Args:
        table: where the objects are believed to be, and what stands on what.
        found: the most probable assignment of single objects.
        seen: the objects of the look, ``centroid`` the middle of their boxes.
    """
    known = {k.expected.object.object_id: k for k in found.known}
    for pile in _piles(table, known):
        known.update(_judged(table, [known[name] for name in pile], found, seen))
    return replace(found, known=tuple(known[k.expected.object.object_id] for k in found.known))


def _piles(table: TrackedObjects, there: Mapping[str, Identity]) -> list[list[str]]:
    """Ids of what stands together, what is below before what is on it."""
    piles: dict[str, list[str]] = {}
    below = {upper: lower for upper, lower in table.rests_on if upper in there and lower in there}
    for name in there:
        root, depth = name, 0
        while root in below and depth < len(below):
            root, depth = below[root], depth + 1
        piles.setdefault(root, []).append(name)
    return [sorted(names, key=lambda n: bottom(table[n])) for names in piles.values() if len(names) > 1]


def _judged(
    table: TrackedObjects, members: Sequence[Identity], found: Identities, seen: Sequence[SceneObject]
) -> dict[str, Identity]:
    """The members whose identity the pile as a whole says better, by id."""
    boxes = [k.expected.object for k in members]
    parts = _parts(boxes, found, seen)
    if not parts:
        return {}  # all of it is gone: the single objects say so
    missing = _missing(table, boxes, max(top(p) for p in parts))
    melted = [k for k in members if k.expected.object.object_id not in missing and not _seen_by_itself(k, seen)]
    lost = {
        k.expected.object.object_id: replace(k, expected=replace(k.expected, hidden=False))
        for k in members
        if k.expected.object.object_id in missing and k.seen is None
    }
    off = _shift([b for b in boxes if b.object_id not in missing], parts)
    if off is None:
        return lost
    there = {
        k.expected.object.object_id: replace(k, seen=None, fallen=False, margin=np.inf, otherwise=None, piled=off)
        for k in melted
    }
    return {**lost, **there}


def _found(identity: Identity) -> bool:
    return identity.seen is not None and identity.margin >= SURE


def _seen_by_itself(identity: Identity, seen: Sequence[SceneObject]) -> bool:
    """Whether it is found, and with its own outline: the middle of a fork and half a bowl is not the fork's."""
    if identity.seen is None or not _found(identity):
        return False
    return identity.fallen or outline_whole(identity.expected.object, seen[identity.seen])


def _parts(
    boxes: Sequence[SceneObject], found: Identities, seen: Sequence[SceneObject]
) -> list[SceneObject]:  # fmt: skip
    """What is seen of the pile: what is over its footprint and surely no other object.

    If nothing is, somebody moved the pile as a whole, and it is what its objects were taken for.
    """
    names = {b.object_id for b in boxes}
    others = {k.seen for k in found.known if k.expected.object.object_id not in names and _found(k)}
    over = [
        s
        for i, s in enumerate(seen)
        if i not in others and any(distance_to_footprint(s.centroid, b) < PART for b in boxes)
    ]
    taken = {k.seen for k in found.known if k.expected.object.object_id in names and k.seen is not None}
    return over or [seen[i] for i in sorted(taken)]


def _missing(table: TrackedObjects, boxes: Sequence[SceneObject], reaches: float) -> set[str]:
    """Ids of those without which the pile would reach as high as is seen [m], from the top down."""
    left = {b.object_id: b for b in boxes}
    missing: set[str] = set()
    while len(left) > 1:
        highest = max(left.values(), key=top)
        below = dict(table.rests_on).get(highest.object_id)
        loaded = any(low == highest.object_id and up in left for up, low in table.rests_on)
        if below is None or loaded:
            break
        without = max(top(b) for n, b in left.items() if n != highest.object_id)
        lowest, tells = top(highest), TELLS
        if below in left and bottom(highest) < top(left[below]) - HIDES:
            lowest, tells = min(lowest, bottom(left[below]) + highest.size[2]), LIES_DEEP
        if lowest - without <= tells or reaches >= (lowest + without) / 2:
            break
        missing.add(highest.object_id)
        del left[highest.object_id]
    return missing


def _shift(boxes: Sequence[SceneObject], parts: Sequence[SceneObject]) -> tuple[float, float] | None:
    """By how much (x, y) [m] the pile was moved, 0 within perception's noise; None when it cannot be all of it."""
    (low, high), (seen_low, seen_high) = _extent(boxes), _extent(parts)
    # How far it reaches beyond where it should; that it falls short says nothing, for parts of it may be hidden.
    off = np.maximum(seen_high - high, 0.0) - np.maximum(low - seen_low, 0.0)
    if np.any(seen_high - seen_low > high - low + GROWN):
        return None
    if np.hypot(*off) < SHIFTED:
        return 0.0, 0.0
    return float(off[0]), float(off[1])


def _extent(boxes: Sequence[SceneObject]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """((2,), (2,)) the least and the greatest (x, y) [m] of the ellipses in some boxes.

    Ellipses, for the box of a round object may be turned either way, and its corners are not the object's.
    """
    middles = np.array([b.centroid[:2] for b in boxes])
    half = np.array([_half_extent(b) for b in boxes])
    return (middles - half).min(axis=0), (middles + half).max(axis=0)


def _half_extent(box: SceneObject) -> tuple[float, float]:
    width, depth, _ = box.size
    c, s = np.cos(box.yaw), np.sin(box.yaw)
    return float(np.hypot(depth * c, width * s)) / 2, float(np.hypot(depth * s, width * c)) / 2
