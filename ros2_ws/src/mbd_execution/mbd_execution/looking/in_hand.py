"""Which object is in the hand, by what is missing on the table."""

from __future__ import annotations

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.objects import Scene

from mbd_execution.looking.expected import expectations, seen_box
from mbd_execution.looking.identities import Identities, identify

MISTAKEN = -4.0  # log-probability that the hand closed on another object than the one it was sent to


def another_in_hand(table: TrackedObjects, scene: Scene, sent_to: str, lying: frozenset[str] = frozenset()) -> str:
    """The object that the hand holds in place of the one it was sent to; "" when it holds that.

    Two explanations of a look are compared as wholes: that the one it was sent to left the table, and that another one
    did, and the first is seen somewhere. It may stand where it stood (the fingers closed on a neighbour), or where the
    other one stood (somebody exchanged the two after the last look).

    Args:
        table: where everything is believed to be, what is in the hand where it was taken.
        scene: the look; its ids mean nothing.
        sent_to: id of the object that the hand closed on, as far as it knew.
        lying: ids of those that the last look showed lying.
    """
    seen = tuple(seen_box(o) for o in scene.objects)
    expected = expectations(table, frozenset(), lying)

    def without(name: str) -> Identities:
        return identify([e for e in expected if e.object.object_id != name], seen)

    free = [e.object.object_id for e in expected if not (e.hidden or e.covered or e.supported)]
    explained = {name: without(name) for name in free if name != sent_to}
    standing = {name: found.total for name, found in explained.items() if found[sent_to].seen is not None}
    best = max(standing, key=lambda name: standing[name], default="")
    return best if best and standing[best] + MISTAKEN > without(sent_to).total else ""
