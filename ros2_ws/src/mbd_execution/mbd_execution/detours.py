"""Ways across the table that pass over nothing too high for them, and never over the teacher's hands.

Seen from above: what is in the way is a rectangle, grown by what the hand takes up sideways. The way is the shortest
one by its corners (a visibility graph); beside one rectangle or two it is exact and takes no search at random.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from mbd_model.errors import MbdError
from mbd_model.execution_progress import Failure
from mbd_model.objects import SceneObject

from mbd_execution.boxes import top
from mbd_execution.goals import ToolGoal, turned
from mbd_execution.hand import HandConfig

INNER, OUTER = 0.14, 0.70  # [m] from the robot's axis, between which the tool may pass
CORNER = 0.004  # [m] beside a grown rectangle, where a way goes round its corner
Point = tuple[float, float]


class NoWayError(MbdError):
    """There is no free way. The text states why.

    Attributes:
        failure: HAND_ZONE or NO_WAY.
    """

    def __init__(self, text: str, failure: Failure) -> None:
        super().__init__(text)
        self.failure = failure


@dataclass(frozen=True)
class Load:
    """What hangs from the tool, fingers or an object: how far it reaches below and sideways [m]."""

    below: float
    reach: float = 0.0


@dataclass(frozen=True)
class Blocked:
    """A rectangle that nothing passes over.

    Attributes:
        x, y: of its middle [m].
        half_x, half_y: half its sides [m] along its own axes, grown.
        yaw: of its axes [rad].
        name: of what is there; "" for the teacher's hands.
    """

    x: float
    y: float
    half_x: float
    half_y: float
    yaw: float
    name: str

    def inside(self, point: Point) -> bool:
        """Whether a point (x, y) [m] is over it."""
        return self.beside(point) < 0.0

    def beside(self, point: Point) -> float:
        """How far a point (x, y) [m] is off it, along its own axes; below 0: over it."""
        u, v = self._own(point)
        return max(abs(u) - self.half_x, abs(v) - self.half_y)

    def grown(self, by: float) -> Blocked:
        """The rectangle with every side farther out [m]."""
        return replace(self, half_x=self.half_x + by, half_y=self.half_y + by)

    def crossed(self, start: Point, end: Point) -> bool:
        """Whether a straight way passes over it."""
        (u0, v0), (u1, v1) = self._own(start), self._own(end)
        enter, leave = 0.0, 1.0
        for at, by, half in ((u0, u1 - u0, self.half_x), (v0, v1 - v0, self.half_y)):
            if abs(by) < 1e-12:
                if abs(at) >= half:
                    return False
                continue
            first, second = sorted(((-half - at) / by, (half - at) / by))
            enter, leave = max(enter, first), min(leave, second)
        return enter < leave - 1e-9

    def corners(self) -> list[Point]:
        """Points just beside its corners."""
        found = []
        for u, v in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
            dx, dy = turned(u * (self.half_x + CORNER), v * (self.half_y + CORNER), self.yaw)
            found.append((self.x + dx, self.y + dy))
        return found

    def _own(self, point: Point) -> Point:
        return turned(point[0] - self.x, point[1] - self.y, -self.yaw)


def zone(hand: HandConfig, grown: float) -> Blocked | None:
    """The teacher's hands as a rectangle grown by so much [m]; None when there is no such zone."""
    x_min, x_max, y_min, y_max = hand.hand_zone
    if x_max <= x_min or y_max <= y_min:
        return None
    half_x, half_y = (x_max - x_min) / 2 + grown, (y_max - y_min) / 2 + grown
    return Blocked((x_min + x_max) / 2, (y_min + y_max) / 2, half_x, half_y, 0.0, "")


def check_goal(goal: ToolGoal, hand: HandConfig, what: str) -> None:
    """Raise NoWayError when a tool goal is over the teacher's hands; ``what`` is to be done there."""
    hands = zone(hand, hand.hand_radius)
    if hands is not None and hands.inside((goal.x, goal.y)):
        raise NoWayError(f"{what} is in the zone of your hands", Failure.HAND_ZONE)


def way_across(
    start: ToolGoal | None,
    goal: ToolGoal,
    height: float,
    *,
    load: Load,
    others: Iterable[SceneObject],
    hand: HandConfig,
) -> tuple[Point, ...]:
    """The corners of the shortest free way across at a height, the goal the last.

    Args:
        start: where the tool is; None: nobody knows, then there is no way to check.
        goal: where it goes.
        height: of the tool [m] on the way.
        load: what hangs from the tool.
        others: what stands on the table.
        hand: the hand's measures.

    Raises:
        NoWayError: everything is blocked.
    """
    end = (goal.x, goal.y)
    if start is None:
        return (end,)
    grown = max(hand.hand_radius, load.reach)
    begin = (start.x, start.y)
    high = [
        Blocked(o.centroid[0], o.centroid[1], o.size[1] / 2, o.size[0] / 2, o.yaw, o.object_id)
        for o in others
        if top(o) > height - load.below
    ]
    # What the tool is over already is left straight up, and what it goes onto is approached straight down; beside one
    # the way keeps no farther off than it begins and ends.
    room = [min(grown, b.beside(begin), b.beside(end)) for b in high]
    blocked = [b.grown(by) for b, by in zip(high, room, strict=True) if by > 0.0]
    hands = zone(hand, grown)
    if hands is not None and not hands.inside(begin):
        blocked.append(hands)
    way = _shortest(begin, end, blocked)
    if way is None:
        names = ", ".join(b.name or "your hands" for b in blocked if b.crossed(begin, end))
        kind = Failure.HAND_ZONE if hands is not None and hands.crossed(begin, end) else Failure.NO_WAY
        raise NoWayError(f"there is no free way past {names}", kind)
    return way


def _shortest(start: Point, end: Point, blocked: Sequence[Blocked]) -> tuple[Point, ...] | None:
    """Dijkstra's search over the corners that see each other; None when the end is not reached."""

    def free(one: Point, other: Point) -> bool:
        return not any(b.crossed(one, other) for b in blocked)

    if free(start, end):
        return (end,)
    corners = [
        c
        for b in blocked
        for c in b.corners()
        if INNER < math.hypot(*c) < OUTER and not any(o.inside(c) for o in blocked)
    ]
    points = [start, *corners, end]
    best = {0: 0.0}
    before: dict[int, int] = {}
    queue = [(0.0, 0)]
    while queue:
        length, at = heapq.heappop(queue)
        if at == len(points) - 1:
            way = []
            while at != 0:
                way.append(points[at])
                at = before[at]
            return tuple(reversed(way))
        if length > best[at]:
            continue
        for other in range(1, len(points)):
            longer = length + math.dist(points[at], points[other])
            if longer < best.get(other, math.inf) and free(points[at], points[other]):
                best[other], before[other] = longer, at
                heapq.heappush(queue, (longer, other))
    return None
