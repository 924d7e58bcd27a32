"""Somebody who disturbs the robot at work: moves, exchanges, takes away, adds and knocks over objects on the table.

He does each disturbance once, by himself and from a seed, only to objects that stand free: not in or under the hand,
nothing on them, themselves on the table. What he took away or knocked over he puts right when he is asked to.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from mbd_cell.cell import Cell
from mbd_cell.layout.placement import MAX_REACH, REGION
from mbd_cell.layout.scenes import ObjectSpec, Shape
from mbd_cell.physics.displacing import push, put
from mbd_cell.physics.simulation import Pose, Simulation

ADVERSARY_STREAM = 31  # of chance
PUSH_BY, PUSH_SPEED = 0.05, 0.1  # [m], [m/s]
CLEAR = 0.04  # [m] around an object set down again
DROP = 0.003  # [m] above an object, from where another one is let go onto it
HAND_RADIUS = 0.13  # [m] around the tool nothing is touched
AWAY = (2.0, -2.0)
UPRIGHT, LYING = 0.995, 0.8  # cosine of its axis to the vertical from which on, and below which, an object counts as


class TableDisturbance(StrEnum):
    """What he can do; LIE is for whoever answers the robot's questions."""

    PUSH = "push"
    SWAP = "swap"
    TAKE = "take"
    ADD = "add"
    KNOCK = "knock"
    LIE = "lie"


@dataclass(frozen=True)
class Disturbed:
    """What was done to which object, in words."""

    what: TableDisturbance
    name: str
    words: str


class Adversary:
    """Disturbs one table.

    Args:
        cell: with the target set on its table.
        what: to be done, once each, in this order; LIE is not his.
        rng: the only source of chance.

    Attributes:
        done: what he has done so far.
    """

    def __init__(self, cell: Cell, what: Sequence[TableDisturbance], rng: np.random.Generator) -> None:
        self.done: list[Disturbed] = []
        self._cell, self._rng = cell, rng
        self._home = {name: cell.simulation.object_pose(name) for name in cell.simulation.objects}
        self._left = [w for w in what if w is not TableDisturbance.LIE]

    @property
    def left(self) -> tuple[TableDisturbance, ...]:
        """What he has not done yet."""
        return tuple(self._left)

    def act(self, wanted: Collection[str]) -> Iterator[None]:
        """Do the next disturbance that can be done now, a control tick an item; nothing when none can.

        Args:
            wanted: true names of the objects the rest of the task needs: these he pushes, takes and knocks over.
        """
        free = [name for name in sorted(self._free()) if name in wanted]
        for what in self._left:
            before = len(self.done)
            yield from self._do(what, free)
            if len(self.done) > before:
                self._left.remove(what)
                return

    def place_of(self, name: str) -> tuple[float, float]:
        """Where an object is (x, y) [m]."""
        x, y, _ = self._physics.object_pose(name).position
        return x, y

    def put_right(self, names: Collection[str]) -> tuple[str, ...]:
        """Bring back or set upright those of these objects that are not on the table, or lie on it.

        Whoever did it: he took it away or knocked it over, or the robot threw it. Which they were.
        """
        mended = []
        for name in sorted(set(names) & set(self._home)):
            now, home = self._physics.object_pose(name), self._home[name]
            gone = now.position[2] < 0.0
            lies = _leans(now) and not any(self._is_in(name, other) for other in self._home if other != name)
            if not gone and not lies:
                continue
            if lies and not gone and self._is_clear(now.position[:2], name):
                home = replace(home, position=(now.position[0], now.position[1], home.position[2]))
            put(self._physics, name, home)
            mended.append(name)
        return tuple(mended)

    def put_back(self, name: str) -> tuple[str, ...]:
        """Set an object that does not stand free upright at its first place, if that is free: which that was."""
        home = self._home.get(name)
        if home is None or name in self._free() or not self._is_clear(home.position, name):
            return ()
        put(self._physics, name, home)
        return (name,)

    def put_onto(self, name: str, other: str, offset: tuple[float, float]) -> tuple[str, ...]:
        """Let an object go upright just above another one, off its middle by (x, y) [m]: which that was."""
        if not {name, other} <= set(self._home):
            return ()
        below = self._physics.object_pose(other)
        height = below.position[2] + (self._spec(other).size[2] + self._spec(name).size[2]) / 2 + DROP
        x, y = below.position[0] + offset[0], below.position[1] + offset[1]
        put(self._physics, name, replace(self._home[name], position=(x, y, height)))
        return (name,)

    @property
    def _physics(self) -> Simulation:
        return self._cell.simulation

    def _do(self, what: TableDisturbance, free: Sequence[str]) -> Iterator[None]:
        order = [free[int(k)] for k in self._rng.permutation(len(free))]
        if what is TableDisturbance.PUSH:
            yield from self._push(order)
        elif what is TableDisturbance.SWAP:
            self._swap()
        elif what is TableDisturbance.TAKE and order:
            before = self._physics.object_pose(order[0])
            put(self._physics, order[0], Pose((*AWAY, 0.1), before.quaternion))
            self._note(what, order[0], "was taken away")
        elif what is TableDisturbance.ADD:
            self._add()
        elif what is TableDisturbance.KNOCK:
            self._knock([name for name in order if self._can_fall(self._spec(name))])

    def _push(self, order: Sequence[str]) -> Iterator[None]:
        for name in order:
            x, y, _ = self._physics.object_pose(name).position
            for turn in self._turns(16):
                dx, dy = math.cos(turn), math.sin(turn)
                if not self._is_clear((x + PUSH_BY * dx, y + PUSH_BY * dy), name):
                    continue
                while math.dist(self._foot(name), (x, y)) < PUSH_BY:
                    push(self._physics, name, (PUSH_SPEED * dx, PUSH_SPEED * dy))
                    yield None
                push(self._physics, name, (0.0, 0.0))
                self._note(TableDisturbance.PUSH, name, f"was pushed by {100 * PUSH_BY:.0f} cm")
                return

    def _foot(self, name: str) -> tuple[float, float]:
        """Where an object stands, (x, y) of the middle of its bottom [m]: one that is pushed leans while it slides."""
        pose, half = self._physics.object_pose(name), self._spec(name).size[2] / 2
        x, y, z, w = pose.quaternion
        return pose.position[0] - half * 2 * (x * z + w * y), pose.position[1] - half * 2 * (y * z - w * x)

    def _swap(self) -> None:
        """Exchange the two free objects of a shape that are most alike in size."""
        free = sorted(self._free())
        pairs = [
            (abs(math.log(math.prod(self._spec(a).size) / math.prod(self._spec(b).size))), a, b)
            for i, a in enumerate(free)
            for b in free[i + 1 :]
            if self._spec(a).shape is self._spec(b).shape
        ]
        if not pairs:
            return
        _, one, other = min(pairs)
        here, there = self._physics.object_pose(one), self._physics.object_pose(other)
        put(self._physics, one, replace(here, position=(*there.position[:2], here.position[2])))
        put(self._physics, other, replace(there, position=(*here.position[:2], there.position[2])))
        self._note(TableDisturbance.SWAP, one, f"changed places with {other}")

    def _add(self) -> None:
        for spare in self._cell.scenes.spares:
            for _ in range(400):
                x, y = (float(self._rng.uniform(REGION[k], REGION[k + 1])) for k in (0, 2))
                if self._is_clear((x, y), spare.name):
                    turn = float(self._rng.uniform(-math.pi, math.pi)) / 2
                    quaternion = (0.0, 0.0, math.sin(turn), math.cos(turn))
                    put(self._physics, spare.name, Pose((x, y, spare.size[2] / 2 + 0.001), quaternion))
                    self._note(TableDisturbance.ADD, spare.name, "was added to the table")
                    return

    def _knock(self, order: Sequence[str]) -> None:
        for name in order:
            before, size = self._physics.object_pose(name), self._spec(name).size
            half, height = size[0] / 2, size[2]
            for turn in self._turns(16):
                way = half + height / 2
                x, y = before.position[0] + way * math.cos(turn), before.position[1] + way * math.sin(turn)
                if not self._is_clear((x, y), name, height / 2):
                    continue
                # A quarter turn about the horizontal axis to the left of the way it falls.
                c, s = math.cos(math.pi / 4), math.sin(math.pi / 4)
                axis = (-math.sin(turn), math.cos(turn))
                put(self._physics, name, Pose((x, y, half + 0.002), (s * axis[0], s * axis[1], 0.0, c)))
                self._note(TableDisturbance.KNOCK, name, "was knocked over")
                return

    def _note(self, what: TableDisturbance, name: str, words: str) -> None:
        self.done.append(Disturbed(what, name, f"{name} {words}"))

    def _spec(self, name: str) -> ObjectSpec:
        return self._physics.objects[name]

    @staticmethod
    def _can_fall(thing: ObjectSpec) -> bool:
        return thing.shape in (Shape.CUP, Shape.BOX) and thing.size[2] > max(thing.size[:2])

    def _turns(self, count: int) -> Iterator[float]:
        for k in self._rng.permutation(count):
            yield 2 * math.pi * int(k) / count

    def _free(self) -> set[str]:
        """Objects that stand upright on the table with nothing on them, away from the hand."""
        tool = self._physics.tool.position
        free = set()
        for name, thing in self._physics.objects.items():
            pose = self._physics.object_pose(name)
            x, y, _, _ = pose.quaternion
            standing = 1 - 2 * (x * x + y * y) > UPRIGHT and abs(pose.position[2] - thing.size[2] / 2) < 0.006
            near = math.dist(pose.position[:2], tool[:2]) < HAND_RADIUS + thing.footprint_radius
            if standing and not near and not self._has_on_it(name):
                free.add(name)
        return free

    def _is_in(self, name: str, other: str) -> bool:
        """Whether an object's middle is above or in the other's outline: then it may lean."""
        here, there = self._physics.object_pose(name).position, self._physics.object_pose(other).position
        return math.dist(here[:2], there[:2]) < self._spec(other).footprint_radius and there[2] > 0.0

    def _has_on_it(self, name: str) -> bool:
        here, radius = self._physics.object_pose(name).position, self._spec(name).footprint_radius
        return any(
            other != name and math.dist(self._physics.object_pose(other).position[:2], here[:2]) < radius
            for other in self._physics.objects
        )

    def _is_clear(self, place: Sequence[float], name: str, radius: float = 0.0) -> bool:
        """Whether an object can stand there [m]: in reach, off the others and the hand."""
        x, y = place[0], place[1]
        inside = REGION[0] <= x <= REGION[1] and REGION[2] <= y <= REGION[3] and math.hypot(x, y) <= MAX_REACH
        own = max(radius, self._spec(name).footprint_radius)
        if not inside or math.dist((x, y), self._physics.tool.position[:2]) < HAND_RADIUS + own:
            return False
        return all(
            math.dist((x, y), self._physics.object_pose(other).position[:2]) > own + thing.footprint_radius + CLEAR
            for other, thing in self._physics.objects.items()
            if other != name
        )


def _leans(pose: Pose) -> bool:
    """Whether an object lies, or nearly so."""
    x, y, _, _ = pose.quaternion
    return 1 - 2 * (x * x + y * y) < LYING
