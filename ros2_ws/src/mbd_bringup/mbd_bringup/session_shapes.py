"""What of a session is drawn in three dimensions: objects, the steps over them, and the mapping between the scenes."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from mbd_model.assists import Assist
from mbd_model.estimate import MappingEstimate
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task

Point = tuple[float, float, float]
Color = tuple[float, float, float, float]
ASSISTED: Color = (0.95, 0.56, 0.17, 1.0)
INFERRED: Color = (0.18, 0.5, 0.82, 1.0)
STEP: Color = (0.85, 0.2, 0.25, 0.9)
WHITE: Color = (1.0, 1.0, 1.0, 1.0)
LETTER = 0.028  # [m] height of text
STEP_LETTER = 0.022  # [m]


class Form(Enum):
    """How a shape looks."""

    BOX = "box"
    TEXT = "text"
    ARROW = "arrow"
    PATH = "path"


@dataclass(frozen=True)
class DrawnShape:
    """One thing to draw, in the robot base frame.

    Attributes:
        group: what it belongs to; viewers switch groups on and off.
        form: how it looks.
        points: [m] the middle of a BOX or TEXT, the ends of an ARROW, the corners of a PATH.
        color: red, green, blue, opacity, each 0..1.
        size: [m] of a BOX, (width, depth, height) at yaw 0; of other forms unused.
        yaw: [rad] of a BOX about z.
        text: of a TEXT.
    """

    group: str
    form: Form
    points: tuple[Point, ...]
    color: Color
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    text: str = ""


@dataclass(frozen=True)
class SessionFacts:
    """What a session has published so far; what it has not is None or empty.

    Attributes:
        scenes: by role.
        task: as demonstrated.
        assists: in force.
        estimate: of the mapping.
    """

    scenes: Mapping[Role, Scene]
    task: Task | None = None
    assists: tuple[Assist, ...] = ()
    estimate: MappingEstimate | None = None


def session_shapes(facts: SessionFacts, aside: Point) -> tuple[DrawnShape, ...]:
    """Every shape of a session.

    Args:
        facts: what is known.
        aside: [m] where the remembered source scene goes once the target scene takes its place on the table.
    """
    target = facts.scenes.get(Role.TARGET)
    source = facts.scenes.get(Role.SOURCE) or (facts.task.source if facts.task else None)
    if target is not None and source is not None and source.stamp > target.stamp:
        target = None  # of an earlier attempt: the source objects are on the table again
    shift = aside if target is not None else (0.0, 0.0, 0.0)
    shapes: list[DrawnShape] = []
    moved = {o.object_id: _moved(o, shift) for o in source.objects} if source else {}
    pairs = _pairs(facts) if target is not None else {}
    for thing in moved.values():
        shapes += _object(thing, "source", thing.object_id)
    if target is not None:
        plays = {t: s for s, (t, _) in pairs.items()}
        for thing in target.objects:
            part = plays.get(thing.object_id)
            shapes += _object(thing, "target", f"{thing.object_id} as {part}" if part else thing.object_id)
        there = {o.object_id: o for o in target.objects}
        for s, (t, assisted) in pairs.items():
            if s in moved and t in there:
                ends = (_top(moved[s]), _top(there[t]))
                shapes.append(DrawnShape("mapping", Form.ARROW, ends, ASSISTED if assisted else INFERRED))
    if facts.task is not None:
        shapes += _steps(facts.task, shift)
    return tuple(shapes)


def _pairs(facts: SessionFacts) -> dict[str, tuple[str, bool]]:
    """Source id -> (target id, assisted by the teacher)."""
    pairs = {s: (t, False) for s, t in facts.estimate.executed.pairs} if facts.estimate else {}
    return pairs | {a.source_id: (a.target_id, True) for a in facts.assists}


def _moved(thing: SceneObject, shift: Point) -> SceneObject:
    x, y, z = (c + s for c, s in zip(thing.centroid, shift, strict=True))
    return replace(thing, centroid=(x, y, z))


def _top(thing: SceneObject) -> Point:
    x, y, z = thing.centroid
    return (x, y, z + thing.size[2] / 2)


def _object(thing: SceneObject, group: str, text: str) -> tuple[DrawnShape, DrawnShape]:
    hue, saturation = (0.0, 0.0) if thing.hue is None else (thing.hue / 360.0, 0.85)
    red, green, blue = colorsys.hsv_to_rgb(hue, saturation, 0.9)
    x, y, z = _top(thing)
    return (
        DrawnShape(f"{group}_objects", Form.BOX, (thing.centroid,), (red, green, blue, 0.55), thing.size, thing.yaw),
        DrawnShape(f"{group}_names", Form.TEXT, ((x, y, z + 1.2 * LETTER),), WHITE, text=text),
    )


def _steps(task: Task, shift: Point) -> list[DrawnShape]:
    """The steps as a path of the tool with a number and a word at each."""
    places = [_sum(s.tool_position, shift) for s in task.steps]
    shapes = [DrawnShape("steps", Form.PATH, tuple(places), STEP)] if len(places) > 1 else []
    for step, (x, y, z) in zip(task.steps, places, strict=True):
        word = "pick" if step.kind is StepKind.PICK else "place"
        # Steps at one spot, as on a stack, one above the other.
        above = z + (2.5 + 1.2 * step.index) * STEP_LETTER
        shapes.append(DrawnShape("steps", Form.TEXT, ((x, y, above),), STEP, text=f"{step.index + 1} {word}"))
    return shapes


def _sum(a: Point, b: Point) -> Point:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
