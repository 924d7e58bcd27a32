"""A teacher who guides a hand through acts: carries, and what looks like one and is none.

The things lie on a grid: boxes that open the hand wide beside narrow ones, a card, a pen, a stack that is there before.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind
from numpy.typing import NDArray

from mbd_demonstration.gripper import GripperAction, GripperEvent

Point = tuple[float, float, float]
TRAVEL_HEIGHT = 0.35  # [m] above the robot's base
OPENING = 0.1  # [m] between the open fingers: what is as wide leaves them open
SPACING = 0.17  # [m] between places: a hand pushes beside a thing without touching the next one


@dataclasses.dataclass(frozen=True)
class ShownActs:
    """What a teacher did.

    Attributes:
        scene: as it was seen before.
        knots: (n, 4) of the tool's path, straight between: time [s], x, y, z [m, robot base frame].
        fingers: (n, 2) knots of the hand: time [s], closure 0 (open) to 1.
        events: when the hand came to hold and let go.
        steps: right (kind, primary object) of each step.
        said: for each act that is no step, words that the task's problems must hold.
    """

    scene: Scene
    knots: NDArray[np.float64]
    fingers: NDArray[np.float64]
    events: tuple[GripperEvent, ...]
    steps: tuple[tuple[StepKind, str], ...]
    said: tuple[str, ...]


def mixed_scene(rng: np.random.Generator) -> Scene:
    """A wide and a narrow box, a block, a pen, a card, and a small box on a large one."""
    places = [(0.35 + SPACING * (k // 4), SPACING * (k % 4 - 1.5)) for k in rng.permutation(12)[:6]]
    sizes = {
        "wide": (0.07, 0.07, 0.08),
        "narrow": (0.025, 0.025, 0.09),
        "block": (0.045, 0.06, 0.05),
        "pen": (0.012, 0.12, 0.012),
        "card": (0.055, 0.085, 0.003),
        "below": (0.065, 0.065, 0.05),
    }
    objects = [
        SceneObject(name, (x, y, size[2] / 2), size) for (name, size), (x, y) in zip(sizes.items(), places, strict=True)
    ]
    x, y, z = objects[-1].centroid
    objects.append(SceneObject("above", (x, y, z + 0.025 + 0.02), (0.04, 0.04, 0.04)))
    return Scene(Role.SOURCE, tuple(objects))


class ActingTeacher:
    """Builds ShownActs act by act; every act ends with the tool high above the table, the hand open.

    Attributes:
        objects: where each now is, by its name.
    """

    def __init__(self, scene: Scene, rng: np.random.Generator, ramp: float = 0.8) -> None:
        self.scene = scene
        self.objects = {o.object_id: o for o in scene.objects}
        self._on = {"above": "below"} if "above" in self.objects else {}
        self._rng = rng
        self._ramp = ramp
        self._knots: list[tuple[float, float, float, float]] = [(0.0, 0.25, 0.0, TRAVEL_HEIGHT)]
        self._fingers: list[tuple[float, float]] = [(0.0, 0.0)]
        self._events: list[GripperEvent] = []
        self._steps: list[tuple[StepKind, str]] = []
        self._said: list[str] = []
        self._wait(1.0)

    def under(self) -> frozenset[str]:
        """What now stands below something."""
        return frozenset(self._on.values())

    def done(self) -> ShownActs:
        """All acts so far."""
        self._wait(1.5)
        self._fingers.append((self._now, self._fingers[-1][1]))
        return ShownActs(
            self.scene,
            np.array(self._knots),
            np.array(self._fingers),
            tuple(self._events),
            tuple(self._steps),
            tuple(self._said),
        )

    def carry(
        self, name: str, onto: str = "", place: tuple[float, float] = (0.0, 0.0), *, withdraw: bool = False
    ) -> None:
        """Pick one up and put it onto another one, or on the table at ``place`` (x, y) [m]; see ``release``."""
        self.take(name)
        self.release(name, onto, place, withdraw=withdraw)

    def take(self, name: str) -> None:
        """Pick one up."""
        self._reach(self._grip(name))
        self._close(self._level(name))
        self._steps.append((StepKind.PICK, name))
        self._rise()

    def release(
        self, name: str, onto: str = "", place: tuple[float, float] = (0.0, 0.0), *, withdraw: bool = False
    ) -> None:
        """Put down what is held; ``withdraw``: the hand rises while its fingers still open."""
        held = self.objects[name]
        if onto:
            x, y = (float(c + self._rng.uniform(-0.008, 0.008)) for c in self.objects[onto].centroid[:2])
            bottom = self.objects[onto].centroid[2] + self.objects[onto].size[2] / 2
        else:
            (x, y), bottom = place, 0.0
        moved = {name} | {upper for upper, lower in self._on.items() if lower == name}
        shift = np.array([x, y, bottom + held.size[2] / 2]) - np.array(held.centroid)
        self._on.pop(name, None)
        for one in moved:
            at = np.array(self.objects[one].centroid) + shift
            self.objects[one] = dataclasses.replace(
                self.objects[one], centroid=(float(at[0]), float(at[1]), float(at[2]))
            )
        if onto:
            self._on[name] = onto
        self._reach(self._grip(name))
        self._open(withdraw=withdraw)
        self._steps.append((StepKind.PLACE, onto or name))
        self._rise()

    def push(self, name: str) -> None:
        """Push one along the table with the closed fist, from beside it; the hand opens before it rises."""
        o = self.objects[name]
        low = min(0.03, o.size[2])
        beside = o.centroid[0] - o.size[1] / 2 - 0.03
        self._reach((beside, o.centroid[1], low))
        self._close(1.0)
        self._go((beside + 0.05, o.centroid[1], low), speed=0.06)
        self._go((beside + 0.01, o.centroid[1], low))
        self._open()
        self._said.append("taken as a push")
        self.objects[name] = dataclasses.replace(o, centroid=(o.centroid[0] + 0.02, *o.centroid[1:]))
        self._rise()

    def hand_over(self, name: str) -> None:
        """Give what is held to somebody in the air, and get it back."""
        self._go((0.45, 0.0, TRAVEL_HEIGHT + 0.1))
        self._open()
        self._wait(1.0)
        self._close(self._level(name))
        self._said.append(f"'{name}' was let go")

    def sag_and_grasp_again(self, name: str) -> None:
        """Grasp one, let the arm sag, open, and grasp it as it should be; it is held then."""
        x, y, z = self._grip(name)
        sag = min(0.025, 0.5 * z)
        self._reach((x, y, z))
        self._close(self._level(name))
        self._go((x, y, z - sag), speed=0.03)
        self._open()
        self._go((x, y, z), speed=0.05)
        self._close(self._level(name))
        self._steps.append((StepKind.PICK, name))
        self._said.append("re-grasp")
        self._rise()

    def fidget(self, share: float) -> None:
        """Close the fingers by a share of their way and open them again at once, while the hand travels."""
        x, y, _ = self._knots[-1][1:]
        begin = self._now
        ramp = 0.5 * self._ramp
        self._fingers += [(begin + 0.2, 0.0), (begin + 0.2 + ramp, share), (begin + 0.2 + 2 * ramp, 0.0)]
        self._go((0.9 - x, -y, TRAVEL_HEIGHT), speed=0.2)
        self._wait(0.5)

    @property
    def _now(self) -> float:
        return self._knots[-1][0]

    def _wait(self, seconds: float) -> None:
        at, *point = self._knots[-1]
        self._knots.append((at + seconds, point[0], point[1], point[2]))

    def _go(self, point: Point, speed: float = 0.25) -> None:
        at, *here = self._knots[-1]
        self._knots.append((at + max(math.dist(here, point) / speed, 0.2), *point))

    def _reach(self, point: Point) -> None:
        self._go((point[0], point[1], TRAVEL_HEIGHT))
        self._go(point)
        self._wait(0.5)

    def _rise(self) -> None:
        x, y = self._knots[-1][1:3]
        self._go((x, y, TRAVEL_HEIGHT))

    def _close(self, level: float) -> None:
        begin, ramp = self._now, self._ramp * max(level, 0.2)
        self._fingers += [(begin, self._fingers[-1][1]), (begin + ramp, level)]
        self._wait(ramp + 0.7)
        self._events.append(GripperEvent(begin + ramp, GripperAction.CLOSE))

    def _open(self, *, withdraw: bool = False) -> None:
        begin, level = self._now, self._fingers[-1][1]
        ramp = self._ramp * max(level, 0.2)
        self._fingers += [(begin, level), (begin + ramp, 0.0)]
        self._events.append(GripperEvent(begin, GripperAction.OPEN))
        if withdraw:
            x, y, z = self._knots[-1][1:]
            self._go((x, y, z + 0.08), speed=0.08)
        self._wait(ramp + 0.5)

    def _grip(self, name: str) -> Point:
        """Where the tool holds it: just below the top, or in the middle of what is flat."""
        x, y, z = self.objects[name].centroid
        return x, y, z + max(self.objects[name].size[2] / 2 - 0.012, 0.0)

    def _level(self, name: str) -> float:
        return 1.0 - min(self.objects[name].size[:2]) / OPENING
