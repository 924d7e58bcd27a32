"""Three blocks to be stacked, on a pretend table that somebody disturbs."""

from __future__ import annotations

import math
from dataclasses import replace

from mbd_execution.execution import Work, begin
from mbd_execution.hand import HandConfig
from mbd_execution.plan import plan
from mbd_execution.synthetic import PretendTable, blocks, demonstration
from mbd_model.objects import Role, Scene, SceneObject

HAND = HandConfig()
SMALL = {"1": (0.04, 0.04, 0.06), "2": (0.08, 0.08, 0.06), "3": (0.05, 0.05, 0.05)}
TARGET = {"1": (0.05, 0.05, 0.07), "2": (0.09, 0.09, 0.05), "3": (0.04, 0.04, 0.04)}
MAPPING = {"s1": "t1", "s2": "t2", "s3": "t3"}
STACK = [("s1", "s2", (0.0, 0.0)), ("s3", "s1", (0.0, 0.0))]
STOOD = (0.45, 0.25)  # where the third block stands at first
HUES = {"t1": 10.0, "t2": 130.0, "t3": 250.0}


def colored(scene: Scene) -> Scene:
    return replace(
        scene, objects=tuple(replace(o, hue=HUES[o.object_id], saturation=0.8) for o in scene.objects)
    )  # fmt: skip


def work_task():
    return demonstration(blocks(Role.SOURCE, "s", SMALL), STACK)


def begun() -> tuple[Work, PretendTable]:
    work = begin(plan(work_task(), colored(blocks(Role.TARGET, "t", TARGET)), MAPPING), HAND, looks=True)
    return work, PretendTable(work.table.objects)


def stands_on(table: PretendTable, upper: str, lower: str) -> bool:
    one, other = table.objects[upper], table.objects[lower]
    gap = one.centroid[2] - one.size[2] / 2 - other.centroid[2] - other.size[2] / 2
    return math.dist(one.centroid[:2], other.centroid[:2]) < 0.015 and abs(gap) < 0.01


def moved(thing: SceneObject, dx: float, dy: float) -> SceneObject:
    x, y, z = thing.centroid
    return replace(thing, centroid=(x + dx, y + dy, z))


class Once:
    """Disturbs the table before the look of a number."""

    def __init__(self, number: int, disturb) -> None:
        self.looks, self._number, self._disturb = 0, number, disturb

    def __call__(self, table: PretendTable) -> None:
        if self.looks == self._number:
            self._disturb(table)
        self.looks += 1
