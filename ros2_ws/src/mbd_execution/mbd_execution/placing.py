"""Where the tool must be to set the held target object down as the demonstration set down the one it stands for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mbd_model.geometry.boxes import outside_box
from mbd_model.objects import SceneObject

from mbd_execution.boxes import adapted_offset, bottom, sides, top, turn_of_frame
from mbd_execution.demonstrated_transfers import DemonstratedTransfer
from mbd_execution.goals import ToolGoal, turn_between, turned
from mbd_execution.hand import HandConfig, nearest_yaw, roomiest

ENOUGH_ROOM = 0.004  # [m] beside an open finger
WALL = 0.006  # [m] a container's wall; perception sees the outside
WALL_GAP = 0.002  # [m] kept from it
RING = 0.01  # [m] between the places tried around one that is taken
INTO = 0.004  # [m] set down this far below the other's top, an object was put into it, not onto it


@dataclass(frozen=True)
class Held:
    """The object in the hand.

    Attributes:
        box: where it stood when it was grasped.
        grasp: the tool then.
    """

    box: SceneObject
    grasp: ToolGoal

    @property
    def below_tool(self) -> float:
        """How far its bottom hangs below the tool [m]."""
        return self.grasp.z - bottom(self.box)

    @property
    def reach(self) -> float:
        """How far it reaches sideways from the tool [m], however it is turned."""
        off = math.dist((self.grasp.x, self.grasp.y), self.box.centroid[:2])
        return off + math.hypot(*self.box.size[:2]) / 2

    def tool_over(self, x: float, y: float, base: float, yaw: float) -> ToolGoal:
        """The tool pose at which the object's middle is over (x, y) and its bottom at height ``base`` [m]."""
        dx, dy = turned(self.grasp.x - self.box.centroid[0], self.grasp.y - self.box.centroid[1], yaw - self.grasp.yaw)
        return ToolGoal(x + dx, y + dy, base + self.below_tool, yaw, self.grasp.tilt)


def release(
    held: Held,
    shown: DemonstratedTransfer,
    receiver: SceneObject | None,
    others: Sequence[SceneObject],
    hand: HandConfig,
) -> ToolGoal:
    """The tool pose at which to open the hand.

    Args:
        held: what is in the hand.
        shown: what the demonstration did.
        receiver: the target object it goes onto or into, where it is now; None: the table.
        others: all other objects, the receiver not among them.
        hand: the hand's measures.
    """
    if receiver is None or shown.receiver is None:
        return _on_table(held, shown, others, hand)
    put = shown.put.centroid
    base = shown.receiver.centroid
    dx, dy = adapted_offset((put[0] - base[0], put[1] - base[1]), shown.receiver, receiver)
    yaw = shown.release.yaw + turn_of_frame(shown.receiver, receiver)
    if _goes_in(held, shown.put, shown.receiver, receiver):
        dx, dy = _within_walls((dx, dy), held, held.box.yaw + yaw - held.grasp.yaw, receiver)
    x, y = receiver.centroid[0] + dx, receiver.centroid[1] + dy
    height = _release_height(held, shown.put, shown.receiver, receiver, hand)
    return roomiest(_turns(held, x, y, height, yaw), others, hand, ENOUGH_ROOM)


def settled(height: float, hand: HandConfig) -> float:
    """Where the bottom of an object is [m] after it was let go at a height [m] just above what it then stands on."""
    return height - hand.release_gap


def _turns(held: Held, x: float, y: float, height: float, yaw: float) -> list[ToolGoal]:
    """The same place with the hand turned either way, the one with less turn from the grasp first."""
    first = nearest_yaw(yaw, held.grasp.yaw, math.pi)
    other = first + math.copysign(math.pi, turn_between(first, held.grasp.yaw) or 1.0)
    return [held.tool_over(x, y, height, turn) for turn in (first, other)]


def _goes_in(held: Held, put: SceneObject, shown: SceneObject, receiver: SceneObject) -> bool:
    """Whether the object is put into the receiver: it was demonstrated so, and it fits."""
    return top(shown) - bottom(put) >= INTO and sides(held.box)[1] <= min(receiver.size[:2]) - 2 * WALL


def _within_walls(
    offset: tuple[float, float], held: Held, yaw: float, receiver: SceneObject
) -> tuple[float, float]:  # fmt: skip
    """The offset (x, y) [m] shortened so that the held object, turned to ``yaw`` [rad], is clear of the walls."""
    width, depth, _ = held.box.size
    c, s = abs(math.cos(yaw - receiver.yaw)), abs(math.sin(yaw - receiver.yaw))
    x, y = turned(*offset, -receiver.yaw)
    room_x = max(receiver.size[1] / 2 - WALL - WALL_GAP - (c * depth + s * width) / 2, 0.0)
    room_y = max(receiver.size[0] / 2 - WALL - WALL_GAP - (s * depth + c * width) / 2, 0.0)
    return turned(min(max(x, -room_x), room_x), min(max(y, -room_y), room_y), receiver.yaw)


def _release_height(
    held: Held, put: SceneObject, shown: SceneObject, receiver: SceneObject, hand: HandConfig
) -> float:  # fmt: skip
    """Height of the held object's bottom [m] at which to let it go onto or into the receiver."""
    if not _goes_in(held, put, shown, receiver):
        return top(receiver) + hand.release_gap
    depth = top(shown) - bottom(put)
    inner = min(receiver.size[:2]) - 2 * WALL
    # As deep as demonstrated in proportion, for what it stands on in there was not seen.
    inside = top(receiver) - depth * receiver.size[2] / shown.size[2] + hand.release_gap
    if inner / 2 > hand.hand_radius - WALL:
        return inside
    # The fingers do not fit in: they stay above the rim, and the object drops the rest.
    return max(inside, top(receiver) + hand.rim_gap - (held.below_tool - hand.fingertip_drop))


def _on_table(
    held: Held, shown: DemonstratedTransfer, others: Sequence[SceneObject], hand: HandConfig
) -> ToolGoal:  # fmt: skip
    """The demonstrated place on the table, or the nearest one to it that is free."""
    x, y = shown.put.centroid[:2]
    height = bottom(held.box) + hand.release_gap
    reach = math.hypot(*held.box.size[:2]) / 2
    free = next(
        (
            place
            for place in _around(x, y)
            if all(float(math.hypot(*outside_box((*place, bottom(o)), o)[:2])) > reach for o in others)
        ),
        (x, y),
    )
    return roomiest(_turns(held, *free, height, shown.release.yaw), others, hand, ENOUGH_ROOM)


def _around(x: float, y: float) -> Iterable[tuple[float, float]]:
    """The place, then others on rings about it, the nearest first."""
    yield x, y
    for ring in range(1, 21):
        for k in range(6 * ring):
            dx, dy = turned(ring * RING, 0.0, 2 * math.pi * k / (6 * ring))
            yield x + dx, y + dy
