"""Every way to grasp an object that its shape allows, best first: as shown, around its sides, by its ends, by its rim.

The hand points down, so a side is taken from above with the fingers beside it. What the demonstration did comes first
where the fingers have room for it; the others are scored by the room they have, by how far the hand has to open, by
reach, and by how far they are from what was shown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from mbd_model.objects import SceneObject

from mbd_execution.boxes import bottom, is_long, long_axis, sides, top
from mbd_execution.demonstrated_transfers import DemonstratedTransfer
from mbd_execution.goals import ToolGoal, turn_between, turned
from mbd_execution.grasps.shown import ENOUGH_ROOM, grasp, rim_places
from mbd_execution.hand import HandConfig, nearest_yaw, room

# What has a rim; where nobody knows, what is wider than the hand is taken so too.
HOLLOW = frozenset({"cup", "bowl", "lunch_box", "box", "tray", "plate"})
NEAREST, FARTHEST = 0.25, 0.60  # [m] from the robot's axis, between which the arm reaches well
SAME_PLACE, SAME_TURN = 0.012, 0.35  # [m], [rad] within which two grasps are one
END = 0.3  # share of its length off the middle of a long object, where its end is taken
ROOM, OPENING, REACH, LIKENESS = 1.0, 0.5, 2.0, 0.3  # weights [1/cm, 1/cm, 1/dm, 1/rad]
MOST_ROOM = 0.03  # [m] more counts for nothing
RIM_WIDTH = 0.02  # [m] at which a hand is that closes around a wall


class GraspKind(StrEnum):
    """How an object is taken."""

    SHOWN = "as shown"
    TOP = "around its sides"
    END = "by its end"
    RIM = "by its rim"


@dataclass(frozen=True)
class GraspCandidate:
    """One way to grasp an object.

    Attributes:
        kind: how.
        goal: the tool pose at which to close the hand.
        score: higher is better.
    """

    kind: GraspKind
    goal: ToolGoal
    score: float


def grasp_candidates(
    box: SceneObject, shown: DemonstratedTransfer, others: Sequence[SceneObject], hand: HandConfig
) -> tuple[GraspCandidate, ...]:  # fmt: skip
    """The ways to grasp it, no two alike, the best first; at least one.

    Args:
        box: the target object where it is now.
        shown: what the demonstration did with the source object.
        others: the other objects where they are now.
        hand: the hand's measures.
    """
    first = grasp(box, shown, others, hand)
    kind = GraspKind.RIM if sides(box)[1] > hand.widest else GraspKind.SHOWN
    found = [GraspCandidate(kind, first, math.inf)]
    if sides(box)[1] < hand.thinnest:
        # The second attempt at a thin one goes farther off its axis, not elsewhere.
        found.append(GraspCandidate(kind, grasp(box, shown, others, hand, 1), math.inf))
    more = [
        GraspCandidate(kind, goal, _score(goal, width, shown, others, hand))
        for kind, goal, width in (*_around(box, hand), *_by_end(box, hand), *_by_rim(box, hand))
    ]
    for candidate in sorted(more, key=lambda c: -c.score):
        if all(_differ(candidate.goal, c.goal) for c in found):
            found.append(candidate)
    if room(first, others, hand) < 0.0 and len(found) > 1 and found[1].score > 0.0:
        return (*found[1:], found[0])
    return tuple(found)


def _around(box: SceneObject, hand: HandConfig) -> Iterator[tuple[GraspKind, ToolGoal, float]]:
    """(kind, tool, width between the fingers [m]) across either side that the hand spans."""
    longer, shorter = sides(box)
    axis = long_axis(box)
    for width, yaw in ((shorter, axis), (longer, axis + math.pi / 2)):
        if width <= hand.widest:
            for turn in (0.0, math.pi):
                yield (
                    GraspKind.TOP,
                    ToolGoal(*box.centroid[:2], _height(box, hand), nearest_yaw(yaw + turn, 0.0)),
                    width,
                )


def _by_end(box: SceneObject, hand: HandConfig) -> Iterator[tuple[GraspKind, ToolGoal, float]]:
    longer, shorter = sides(box)
    if not is_long(box) or shorter > hand.widest:
        return
    axis = long_axis(box)
    for share in (END, -END):
        dx, dy = turned(share * longer, 0.0, axis)
        for turn in (0.0, math.pi):
            x, y = box.centroid[0] + dx, box.centroid[1] + dy
            yield GraspKind.END, ToolGoal(x, y, _height(box, hand), nearest_yaw(axis + turn, 0.0)), shorter


def _by_rim(box: SceneObject, hand: HandConfig) -> Iterator[tuple[GraspKind, ToolGoal, float]]:
    """Finger 1 outside, the two others inside, at places all around."""
    shorter = sides(box)[1]
    if box.object_class not in HOLLOW and shorter <= hand.widest:
        return
    if shorter / 2 < hand.finger_side + hand.finger_radius:
        return  # two fingers do not fit inside
    for goal in rim_places(box, 0.0, hand):
        yield GraspKind.RIM, goal, RIM_WIDTH


def _height(box: SceneObject, hand: HandConfig) -> float:
    lowest = bottom(box) + hand.fingertip_drop + hand.table_gap
    return max(top(box) - hand.grasp_depth, lowest)


def _score(
    goal: ToolGoal, width: float, shown: DemonstratedTransfer, others: Sequence[SceneObject], hand: HandConfig
) -> float:
    """Higher is better; below 0 when the fingers have less room than they should."""
    space = room(goal, others, hand)
    if space < ENOUGH_ROOM / 2:
        return 100 * (space - ENOUGH_ROOM)
    reach = math.hypot(goal.x, goal.y)
    beyond = max(reach - FARTHEST, NEAREST - reach, 0.0)
    unlike = abs(turn_between(shown.grasp.yaw, goal.yaw, math.pi))
    score = ROOM * 100 * min(space, MOST_ROOM) + OPENING * 100 * max(hand.widest - width, 0.0)
    return score - REACH * 10 * beyond - LIKENESS * unlike


def _differ(one: ToolGoal, other: ToolGoal) -> bool:
    apart = math.dist((one.x, one.y, one.z), (other.x, other.y, other.z))
    return apart > SAME_PLACE or abs(turn_between(one.yaw, other.yaw)) > SAME_TURN
