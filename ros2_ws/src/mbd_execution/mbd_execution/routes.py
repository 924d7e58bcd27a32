"""The motions of a pick, of a place and of letting go, each approached from above."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mbd_model.objects import SceneObject

from mbd_execution.boxes import top
from mbd_execution.goals import Grip, Motion, MoveTo, ToolGoal
from mbd_execution.hand import HandConfig

TRAVEL, APPROACH = 0.25, 0.12  # [m/s]


def safe_height(others: Iterable[SceneObject], hanging: float, hand: HandConfig) -> float:
    """Height of the tool [m] at which what hangs ``hanging`` [m] below it passes over all of the others."""
    return min(hand.highest, max((top(o) for o in others), default=0.0) + hanging + hand.clearance)


def over(goal: ToolGoal, tool: ToolGoal | None, height: float, hand: HandConfig) -> list[Motion]:
    """Up from where the tool is, across, and down to just above the goal; ``height`` [m] is that of the crossing."""
    height = max(height, min(goal.z + hand.hover, hand.highest))
    motions: list[Motion] = []
    if tool is not None and tool.z < height - 0.01:
        motions.append(MoveTo(tool.at_height(height), TRAVEL))
    motions.append(MoveTo(goal.at_height(height), TRAVEL))
    if height > goal.z + hand.hover + 0.01:
        motions.append(MoveTo(goal.at_height(goal.z + hand.hover), TRAVEL))
    return motions


def pick(
    goal: ToolGoal, tool: ToolGoal | None, objects: Sequence[SceneObject], hand: HandConfig
) -> tuple[Motion, ...]:  # fmt: skip
    """Open the hand, go down onto the object, close, and lift it a little."""
    height = safe_height(objects, hand.fingertip_drop, hand)
    lift = goal.at_height(min(goal.z + hand.hover, hand.highest))
    return (
        Grip(close=False),
        *over(goal, tool, height, hand),
        MoveTo(goal, APPROACH),
        Grip(close=True),
        MoveTo(lift, APPROACH),
    )


def place(
    goal: ToolGoal, tool: ToolGoal | None, hanging: float, objects: Sequence[SceneObject], hand: HandConfig
) -> tuple[Motion, ...]:
    """Carry over everything, go straight down, open, and go up again.

    Args:
        goal: where to open the hand.
        tool: where it is now, None when that is not known.
        hanging: how far the held object reaches below the tool [m].
        objects: what stands on the table.
        hand: the hand's measures.
    """
    height = safe_height(objects, max(hanging, hand.fingertip_drop), hand)
    up = goal.at_height(min(goal.z + hand.hover, hand.highest))
    return (*over(goal, tool, height, hand), MoveTo(goal, APPROACH), Grip(close=False), MoveTo(up, APPROACH))


def aside(
    goal: ToolGoal, tool: ToolGoal | None, hanging: float, objects: Sequence[SceneObject], hand: HandConfig
) -> list[Motion]:
    """Out of the camera's view, above everything; nothing is approached there.

    Args:
        goal: where the tool is out of view.
        tool: where it is now, None when that is not known.
        hanging: how far what it holds, or its fingers, reach below it [m].
        objects: what stands on the table.
        hand: the hand's measures.
    """
    height = max(safe_height(objects, hanging, hand), goal.z)
    motions: list[Motion] = []
    if tool is not None and tool.z < height - 0.01:
        motions.append(MoveTo(tool.at_height(height), TRAVEL))
    motions.append(MoveTo(goal.at_height(height), TRAVEL))
    return motions


def let_go(tool: ToolGoal | None, hand: HandConfig) -> tuple[Motion, ...]:
    """Open the hand and go up from where it is."""
    motions: list[Motion] = [Grip(close=False)]
    if tool is not None:
        motions.append(MoveTo(tool.at_height(min(tool.z + hand.hover, hand.highest)), APPROACH))
    return tuple(motions)
