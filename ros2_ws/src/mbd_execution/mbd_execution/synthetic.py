"""Small demonstrations with tool poses, and arms that do as they are commanded or fail, for tests and examples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

from mbd_execution.choosing import next_motion
from mbd_execution.execution import Work, motion_ended
from mbd_execution.goals import Ended, Grip, Motion

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


def obeys(motion: Motion, _work: Work) -> Ended:
    """An arm that does what it is commanded, and always finds something to hold."""
    return Ended(True, holding=True, reached=None if isinstance(motion, Grip) else motion.goal)
