"""Who watches the robot at work by the simulation's truth: what it drops, and what it bumps into."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mbd_cell.cell import Cell
from mbd_execution.work.state import Work
from mbd_model.execution_progress import Purpose

CARRIED_APART = 0.03  # [m] a thing this far from where it was in the hand has left it
APART_TICKS = 25  # two contacts of the same things this many ticks apart are two
WITH_SOMETHING = frozenset({Purpose.PLACE, Purpose.RETURN, Purpose.LET_GO})


@dataclass(frozen=True)
class Carrying:
    """An object in the hand, and where it was to the tool when the hand had closed [m]."""

    name: str
    offset: tuple[float, float, float]


class Referee:
    """Watches one table.

    Args:
        cell: with the robot at work.

    Attributes:
        handled: true names of the objects that the hand may touch just now.
        dropped: objects that left the hand by themselves, in order.
        unnoticed: those of them that were reported as placed all the same.
        arm_table, arm_objects: (robot's body, other thing) of each contact.
    """

    def __init__(self, cell: Cell) -> None:
        self.handled: Collection[str] = ()
        self.dropped: list[str] = []
        self.unnoticed: list[str] = []
        self.arm_table: list[tuple[str, str]] = []
        self.arm_objects: list[tuple[str, str]] = []
        self._cell = cell
        self._carrying: Carrying | None = None
        self._lost: str | None = None
        self._last: str | None = None
        self._ticks, self._watching = 0, True
        self._last_contact: dict[tuple[int, int], int] = {}
        model = cell.model
        robot = model.body_rootid[model.body(cell.robot.hand_body).id]
        self._is_robot = model.body_rootid[model.geom_bodyid] == robot
        self._table = model.geom("table").id
        self._object_of_body = {model.body(name).id: name for name in cell.simulation.objects}
        objects = np.array(sorted(self._object_of_body))
        self._is_object = np.isin(model.geom_bodyid, objects)

    def closed(self, holding: bool) -> str | None:
        """The hand has closed and reported whether it holds something; the true object nearest to it, if it does."""
        self._carrying = self._lost = None
        if not holding:
            return None
        physics, tool = self._cell.simulation, self._cell.simulation.tool.position
        near = [
            (math.dist(physics.object_pose(name).position[:2], tool[:2]), name)
            for name in physics.touching_fingers()
        ]  # fmt: skip
        if not near:
            self._lost = "nothing"  # it believes it holds something that it does not
            self.dropped.append("nothing between the fingers")
            return None
        name = self._cell.holding or min(near)[1]
        self._carrying, self._last = Carrying(name, self._offset(name)), name
        return name

    def opening(self, placed: bool) -> None:
        """The hand is about to open; ``placed``: the robot takes what it held to be where it should."""
        if placed and self._lost is not None:
            self.unnoticed.append(self._lost)
        self._carrying = self._lost = None

    def handles(self, work: Work) -> None:
        """A motion comes: what the hand may touch in it.

        By place: of two that somebody exchanged, the hand goes to what stands where it saw the one it wants.
        """
        course = work.course
        if course is None:
            self.handled = ()
            return
        in_hand: set[str] = {self._last} if course.purpose in WITH_SOMETHING and self._last else set()
        in_hand |= {self._carrying.name} if self._carrying else set()
        meant = {course.transfer.receiver} | (set() if in_hand else {course.transfer.held})
        places = [o.centroid for o in work.table.objects if o.object_id in meant]
        self.handled = in_hand | {self._nearest(place, in_hand) for place in places}

    def _nearest(self, place: Sequence[float], but: Collection[str]) -> str:
        """True name of the object whose middle is nearest to a place (x, y, z) [m]."""
        physics = self._cell.simulation
        others = [name for name in physics.objects if name not in but]
        return min(others, key=lambda name: math.dist(physics.object_pose(name).position, place))

    def rest(self) -> None:
        """The robot's work is over: what happens to things from now on is not its doing."""
        self._watching = False

    def tick(self) -> None:
        """A control tick has passed."""
        if not self._watching:
            return
        self._ticks += 1
        if self._carrying is not None:
            moved = math.dist(self._offset(self._carrying.name), self._carrying.offset)
            if moved > CARRIED_APART:
                self.dropped.append(self._carrying.name)
                self._lost, self._carrying = self._carrying.name, None
        self._look_at_contacts()

    def _offset(self, name: str) -> tuple[float, float, float]:
        """Position of an object in the tool's frame [m]."""
        physics = self._cell.simulation
        tool, thing = physics.tool, physics.object_pose(name)
        turn = np.zeros(9)
        x, y, z, w = tool.quaternion
        mujoco.mju_quat2Mat(turn, np.array((w, x, y, z)))
        away = turn.reshape(3, 3).T @ np.subtract(thing.position, tool.position)
        return float(away[0]), float(away[1]), float(away[2])

    def _look_at_contacts(self) -> None:
        data, model = self._cell.simulation.data, self._cell.model
        if data.ncon == 0:
            return
        pairs = np.asarray(data.contact.geom)[np.asarray(data.contact.dist) <= 0.0]
        robots = self._is_robot[pairs]
        for (one, other), (first, second) in zip(pairs[robots.any(axis=1)], robots[robots.any(axis=1)], strict=True):
            if first and second:
                continue
            mine, thing = (one, other) if first else (other, one)
            key = (int(model.geom_bodyid[mine]), int(model.geom_bodyid[thing]))
            before, self._last_contact[key] = self._last_contact.get(key), self._ticks
            if before is not None and self._ticks - before < APART_TICKS:
                continue
            if thing == self._table:
                self.arm_table.append((model.body(key[0]).name, "table"))
            elif self._is_object[thing] and self._object_of_body[key[1]] not in self.handled:
                self.arm_objects.append((model.body(key[0]).name, self._object_of_body[key[1]]))
