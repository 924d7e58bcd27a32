"""The motions of a pick, of a place and of letting go, each approached from above."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from mbd_model.objects import SceneObject

from mbd_execution.boxes import top
from mbd_execution.detours import Load, check_goal, way_across
from mbd_execution.goals import Grip, Motion, MoveTo, ToolGoal
from mbd_execution.hand import HandConfig

TRAVEL, APPROACH = 0.25, 0.12  # [m/s]


def safe_height(others: Iterable[SceneObject], hanging: float, hand: HandConfig) -> float:
    """Height of the tool [m] at which what hangs ``hanging`` [m] below it passes over all of the others."""
    return min(hand.highest, max((top(o) for o in others), default=0.0) + hanging + hand.clearance)


def over(
    goal: ToolGoal, tool: ToolGoal | None, load: Load, objects: Sequence[SceneObject], hand: HandConfig
) -> list[Motion]:
    """Up from where the tool is, across above everything, round what is too high, and down to just above the goal.

    Raises:
        NoWayError: there is no free way across, or the goal is over the teacher's hands.
    """
    check_goal(goal, hand, "the place")
    height = max(safe_height(objects, load.below, hand), min(goal.z + hand.hover, hand.highest))
    motions = _across(goal, tool, height, load=load, objects=objects, hand=hand)
    if height > goal.z + hand.hover + 0.01:
        motions.append(MoveTo(goal.at_height(goal.z + hand.hover), TRAVEL))
    return motions


def _across(
    goal: ToolGoal,
    tool: ToolGoal | None,
    height: float,
    *,
    load: Load,
    objects: Sequence[SceneObject],
    hand: HandConfig,
) -> list[Motion]:
    """Up from where the tool is to a height [m], and across at it."""
    motions: list[Motion] = []
    if tool is not None and tool.z < height - 0.01:
        motions.append(MoveTo(tool.at_height(height), TRAVEL))
    for x, y in way_across(tool, goal, height, load=load, others=objects, hand=hand):
        motions.append(MoveTo(replace(goal, x=x, y=y, z=height), TRAVEL))
    return motions


def pick(
    goal: ToolGoal, tool: ToolGoal | None, objects: Sequence[SceneObject], hand: HandConfig
) -> tuple[Motion, ...]:  # fmt: skip
    """Open the hand, go down onto the object, close, and lift it a little.

    Raises:
        NoWayError: there is no free way across, or the goal is over the teacher's hands.
    """
    lift = goal.at_height(min(goal.z + hand.hover, hand.highest))
    return (
        Grip(close=False),
        *over(goal, tool, Load(hand.fingertip_drop), objects, hand),
        MoveTo(goal, APPROACH),
        Grip(close=True),
        MoveTo(lift, APPROACH),
    )


def place(
    goal: ToolGoal, tool: ToolGoal | None, load: Load, objects: Sequence[SceneObject], hand: HandConfig
) -> tuple[Motion, ...]:
    """Carry over everything, go straight down, open, and go up again.

    The hand is closed once more above the place and at it: fingers that meet there hold nothing any more.

    Args:
        goal: where to open the hand.
        tool: where it is now, None when that is not known.
        load: the fingers and what they hold.
        objects: what stands on the table.
        hand: the hand's measures.

    Raises:
        NoWayError: there is no free way across, or the goal is over the teacher's hands.
    """
    up = goal.at_height(min(goal.z + hand.hover, hand.highest))
    way = over(goal, tool, load, objects, hand)
    check = Grip(close=True)
    return (*way, check, MoveTo(goal, APPROACH), check, Grip(close=False), MoveTo(up, APPROACH))


def aside(
    goal: ToolGoal, tool: ToolGoal | None, load: Load, objects: Sequence[SceneObject], hand: HandConfig
) -> list[Motion]:
    """Out of the camera's view, above everything; nothing is approached there.

    Args:
        goal: where the tool is out of view.
        tool: where it is now, None when that is not known.
        load: the fingers and what they hold.
        objects: what stands on the table.
        hand: the hand's measures.

    Raises:
        NoWayError: there is no free way across.
    """
    height = safe_height(objects, load.below, hand)
    motions = _across(goal, tool, height, load=load, objects=objects, hand=hand)
    # Far out the arm does not reach as high as beside itself.
    if goal.z > height + 0.01:
        motions.append(MoveTo(goal, TRAVEL))
    return motions


def let_go(tool: ToolGoal | None, hand: HandConfig) -> tuple[Motion, ...]:
    """Open the hand and go up from where it is."""
    motions: list[Motion] = [Grip(close=False)]
    if tool is not None:
        motions.append(MoveTo(tool.at_height(min(tool.z + hand.hover, hand.highest)), APPROACH))
    return tuple(motions)
