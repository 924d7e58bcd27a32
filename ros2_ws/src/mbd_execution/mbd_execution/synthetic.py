"""Small demonstrations with tool poses, and arms that do as they are commanded or fail, for tests and examples."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, motion_ended
from mbd_execution.goals import Ended, Look, Motion, MoveTo, ToolGoal, turned

DOWN = (1.0, 0.0, 0.0, 0.0)
BELOW_TOP = 0.02  # [m] at which the hand demonstrably takes things
Sides = tuple[float, float, float]


def blocks(role: Role, prefix: str, sizes: dict[str, Sides], yaw: float = 0.0) -> Scene:
    """Blocks of these sizes (width, depth, height) [m] by number, 25 cm apart along y, all turned by ``yaw`` [rad]."""
    found = []
    for k, (number, size) in enumerate(sizes.items()):
        middle = (0.45, -0.25 + 0.25 * k, size[2] / 2)
        found.append(SceneObject(f"{prefix}{number}", middle, size, yaw=yaw, box_center=middle))
    return Scene(role, tuple(found))


def demonstration(source: Scene, moves: list[tuple[str, str | None, tuple[float, float]]]) -> Task:
    """Each object in turn put onto another one (None: the table), its middle off the other's by (x, y) [m].

    On the table (x, y) is the place itself.
    """
    places = {o.object_id: o.centroid for o in source.objects}
    sizes = {o.object_id: o.size for o in source.objects}
    steps: list[TaskStep] = []
    for held, onto, offset in moves:
        x, y = offset
        hang = sizes[held][2] / 2 - BELOW_TOP
        at = places[held]
        base = 0.0
        if onto is not None:
            x, y = places[onto][0] + offset[0], places[onto][1] + offset[1]
            base = places[onto][2] + sizes[onto][2] / 2
        now = (x, y, base + sizes[held][2] / 2)
        for kind, primary, place in ((StepKind.PICK, held, at), (StepKind.PLACE, onto or held, now)):
            tool = (place[0], place[1], place[2] + hang)
            step = TaskStep(len(steps), kind, primary, 0.0, tool_position=tool, tool_quaternion=DOWN)
            steps.append(replace(step, start=float(len(steps)), end=float(len(steps) + 1)))
        places[held] = now
    return Task(source, tuple(steps))


def play(work: Work, answer: Callable[[Motion, Work], Ended], limit: int = 500) -> tuple[Work, list[Motion]]:
    """Let an arm do the work until there is nothing to do; ``answer`` states how each motion ends.

    Raises:
        RuntimeError: there is no end to it.
    """
    made: list[Motion] = []
    while len(made) < limit:
        work, motion = next_motion(work, allowed=True)
        if motion is None:
            return work, made
        made.append(motion)
        work = motion_ended(work, answer(motion, work))
    raise RuntimeError(f"{limit} motions and no end")


def obeys(motion: Motion, work: Work) -> Ended:
    """An arm that does what it is commanded, always finds something to hold, and sees what is believed."""
    if isinstance(motion, Look):
        return Ended(True, seen=as_seen(work.others(work.carried.held.box.object_id if work.carried else None)))
    return Ended(True, holding=True, reached=motion.goal if isinstance(motion, MoveTo) else None)


def as_seen(objects: Sequence[SceneObject]) -> Scene:
    """A scene of boxes as perception gives it: newly numbered, each as high as its top is above the table."""
    found = []
    for number, thing in enumerate(objects):
        height = thing.centroid[2] + thing.size[2] / 2
        middle = (thing.centroid[0], thing.centroid[1], height / 2)
        size = (thing.size[0], thing.size[1], height)
        found.append(replace(thing, object_id=f"seen{number}", centroid=middle, box_center=middle, size=size))
    return Scene(Role.TARGET, tuple(found))


class PretendTable:
    """A table of boxes and an arm that moves them: what is under the closing fingers goes with them.

    Unlike the cell it has no physics: what is let go stays at the height where it was let go, less the gap.

    Args:
        objects: as they stand; ``centroid`` is the middle of the box.

    Attributes:
        objects: where each is now, by name.
        held: name of what is in the hand, "" for nothing.
        before_look: called with the table before each look, to disturb it.
        slips: called with the name of what is about to be held; True: it slips out.
    """

    def __init__(self, objects: Sequence[SceneObject]) -> None:
        self.objects = {o.object_id: o for o in objects}
        self.held = ""
        self.tool: ToolGoal | None = None
        self._grasp: tuple[ToolGoal, SceneObject] | None = None
        self.before_look: Callable[[PretendTable], None] = lambda _: None
        self.slips: Callable[[str], bool] = lambda _: False

    def __call__(self, motion: Motion, work: Work) -> Ended:
        """How a motion ends."""
        if isinstance(motion, MoveTo):
            self.tool = motion.goal
            return Ended(True, reached=self.tool)
        if isinstance(motion, Look):
            self.before_look(self)
            return Ended(True, seen=as_seen([o for name, o in self.objects.items() if name != self.held]))
        if motion.close:
            self._close()
            return Ended(True, holding=bool(self.held), reached=self.tool)
        self._open(work.hand.release_gap)
        return Ended(True, reached=self.tool)

    def grab(self, name: str) -> None:
        """Hold an object where the tool is."""
        if self.tool is not None:
            self.held, self._grasp = name, (self.tool, self.objects[name])

    def _close(self) -> None:
        if self.held or self.tool is None:
            return
        under = [o for o in self.objects.values() if self._within_fingers(o, self.tool)]
        if under:
            highest = max(under, key=lambda o: o.centroid[2] + o.size[2] / 2)
            if not self.slips(highest.object_id):
                self.grab(highest.object_id)

    @staticmethod
    def _within_fingers(thing: SceneObject, tool: ToolGoal) -> bool:
        reach = max(thing.size[:2]) / 2 + 0.01
        top = thing.centroid[2] + thing.size[2] / 2
        apart = math.dist((tool.x, tool.y), thing.centroid[:2])
        return apart < reach and top - 0.06 < tool.z < top + 0.02

    def _open(self, gap: float) -> None:
        if not self.held or self._grasp is None or self.tool is None:
            return
        grasp, box = self._grasp
        dx, dy = turned(box.centroid[0] - grasp.x, box.centroid[1] - grasp.y, self.tool.yaw - grasp.yaw)
        z = box.centroid[2] + self.tool.z - grasp.z - gap
        yaw = box.yaw + self.tool.yaw - grasp.yaw
        self.objects[self.held] = replace(box, centroid=(self.tool.x + dx, self.tool.y + dy, z), yaw=yaw)
        self.held, self._grasp = "", None
