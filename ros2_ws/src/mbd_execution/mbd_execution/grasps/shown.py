"""Where the tool must be to grasp a target object as the demonstration grasped the source object it stands for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from mbd_model.objects import SceneObject

from mbd_execution.boxes import adapted_offset, bottom, is_long, long_axis, sides, top
from mbd_execution.demonstrated_transfers import DemonstratedTransfer
from mbd_execution.goals import ToolGoal, turn_between
from mbd_execution.hand import HandConfig, in_base, nearest_yaw, roomiest

ENOUGH_ROOM = 0.008  # [m] beside an open finger
RIM_PLACES = 12
STRAIGHT_WALLS = frozenset({"cup", "lunch_box", "box", "tray"})


def grasp(
    box: SceneObject, shown: DemonstratedTransfer, others: Sequence[SceneObject], hand: HandConfig, attempt: int = 0
) -> ToolGoal:  # fmt: skip
    """The tool pose at which to close the hand.

    The tool is above the box's middle, off it by the demonstrated offset in proportion; as deep below the top as
    demonstrated, if the hand stays off what the box stands on; turned so that the fingers close across the same side.
    What no hand can span is taken by its rim. What is thinner than the gap that closed fingertips leave is pushed by
    two of them against the third: the tool is as low as it may, off the middle towards that one, farther at a second
    attempt.

    Args:
        box: the target object where it is now.
        shown: what the demonstration did with the source object.
        others: the other objects where they are now.
        hand: the hand's measures.
        attempt: how often this grasp has failed before.
    """
    if sides(box)[1] > hand.widest:
        return _rim_grasp(box, shown, others, hand)
    dx, dy = adapted_offset(
        (shown.grasp.x - shown.picked.centroid[0], shown.grasp.y - shown.picked.centroid[1]), shown.picked, box
    )
    thin = sides(box)[1] < hand.thinnest
    depth = hand.grasp_depth if thin else min(max(top(shown.picked) - shown.grasp.z, 0.0), hand.grasp_depth)
    lowest = bottom(box) + hand.fingertip_drop + hand.table_gap
    place = (box.centroid[0] + dx, box.centroid[1] + dy, max(top(box) - depth, lowest))
    goals = [ToolGoal(*place, yaw) for yaw in _yaws(box, shown, hand)]
    if thin:
        goals = [_off_axis(goal, hand.thin_shift * (1 + attempt)) for goal in goals]
    return roomiest(goals, others, hand, ENOUGH_ROOM)


def _off_axis(goal: ToolGoal, shift: float) -> ToolGoal:
    """The goal moved ``shift`` [m] towards finger 1."""
    x, y = in_base(goal, (0.0, -shift))
    return replace(goal, x=x, y=y)


def _yaws(box: SceneObject, shown: DemonstratedTransfer, hand: HandConfig) -> list[float]:
    """Turns of the hand [rad] that close across the demonstrated side, the one nearest to the demonstrated first."""
    if not is_long(box):
        first = nearest_yaw(box.yaw, shown.grasp.yaw, math.pi / 2)
        return [first + k * math.pi / 2 for k in (0, 2, -1, 1)]
    # At a yaw along the long axis the hand, closing along its y axis, spans the shorter side.
    across = long_axis(box)
    if is_long(shown.picked) and sides(box)[0] <= hand.widest:
        off_axis = abs(turn_between(long_axis(shown.picked), shown.grasp.yaw, math.pi))
        across += math.pi / 2 if off_axis > math.pi / 4 else 0.0
    first = nearest_yaw(across, shown.grasp.yaw, math.pi)
    return [first, first + math.pi]


def _rim_grasp(
    box: SceneObject, shown: DemonstratedTransfer, others: Sequence[SceneObject], hand: HandConfig
) -> ToolGoal:
    """The place of its rim where finger 1 has room."""
    goals = rim_places(box, shown.grasp.yaw, hand)
    if goals[0].tilt:
        # A hand that leans towards the robot reaches worst; to a side it needs the least turn.
        goals.sort(key=lambda g: abs(g.yaw))
    else:
        # Nearer to the robot it reaches better; of two places as near, the one with less turn.
        goals.sort(key=lambda g: (round(math.hypot(g.x, g.y), 2), abs(g.yaw)))
    return roomiest(goals, others, hand, 3 * ENOUGH_ROOM)


def rim_places(box: SceneObject, first: float, hand: HandConfig) -> list[ToolGoal]:
    """Finger 1 outside, the two others inside: the tool over the rim, at places all around.

    The other way round a bowl's curved wall would pass between fingertips that do not quite meet. Along a wall that
    leans outwards the hand leans too: else the bowl turns until its wall stands along the fingers.

    Args:
        box: the object.
        first: turn of the hand [rad] at one of the places.
        hand: the hand's measures.
    """
    out = sides(box)[1] / 2 - hand.rim_in
    tilt = 0.0 if box.object_class in STRAIGHT_WALLS else hand.rim_tilt
    goals = []
    for k in range(RIM_PLACES):
        # Outwards is the tool's -y axis: (-sin yaw, cos yaw) in the base.
        yaw = nearest_yaw(first + 2 * math.pi * k / RIM_PLACES, 0.0)
        x, y = box.centroid[0] - out * math.sin(yaw), box.centroid[1] + out * math.cos(yaw)
        goals.append(ToolGoal(x, y, top(box) - hand.rim_depth, yaw, tilt))
    return goals
