"""From which recorded stage a session is computed again, and what of it differs from what was published then.

``assists`` (the last stage): estimates from the recorded task, target scene and assists. ``scenes``: the task too, from
the source scene, the tool's path and the gripper. ``clouds`` (the rawest): the scenes too, from RGB-D.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TypeVar

from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_model.objects import Scene, SceneObject
from mbd_model.task import Task

from mbd_study.recompute.reevaluation import Difference

Value = TypeVar("Value", Scene, Task)

# What JPEG does to an object's colour, and nothing may do to its place: depth is recorded without loss.
HUE_TOLERANCE = 4.0  # [deg]
SATURATION_TOLERANCE = 0.05
LENGTH_TOLERANCE = 3e-3  # [m]
TIME_TOLERANCE = 0.1  # [s]: a recorder learns of a demonstration's start somewhat later or sooner than its node


class RecomputeFrom(StrEnum):
    """What a computation starts from."""

    CLOUDS = "clouds"
    SCENES = "scenes"
    ASSISTS = "assists"


@dataclass(frozen=True)
class StageCheck:
    """One scene or task, computed again.

    Attributes:
        what: "source scene", "target scene" or "task".
        log_time: of the recorded one [ns].
        differences: () when they agree within the tolerances above.
        skipped: why it could not be computed; "" when it was.
    """

    what: str
    log_time: int
    differences: tuple[Difference, ...]
    skipped: str = ""


def scene_differences(recorded: Scene, computed: Scene) -> tuple[Difference, ...]:
    """What differs between two looks at the same frames."""
    if len(recorded.objects) != len(computed.objects):
        return (Difference("objects", str(len(recorded.objects)), str(len(computed.objects))),)
    pairs = zip(recorded.objects, computed.objects, strict=True)
    return tuple(d for old, new in pairs for d in _object_differences(old, new))


def _object_differences(old: SceneObject, new: SceneObject) -> list[Difference]:
    name = old.object_id
    found = [
        Difference(f"{name}.{field}", str(getattr(old, field)), str(getattr(new, field)))
        for field in ("object_id", "object_class", "affordances", "properties", "relations")
        if getattr(old, field) != getattr(new, field)
    ]
    for field in ("centroid", "size", "box_center"):
        before, after = getattr(old, field), getattr(new, field)
        if before is None or after is None:
            continue
        if max(abs(a - b) for a, b in zip(before, after, strict=True)) > LENGTH_TOLERANCE:
            found.append(Difference(f"{name}.{field}", _metres(before), _metres(after)))
    if (old.hue is None) != (new.hue is None) or _hue_distance(old.hue, new.hue) > HUE_TOLERANCE:
        found.append(Difference(f"{name}.hue", str(old.hue), str(new.hue)))
    if abs(old.saturation - new.saturation) > SATURATION_TOLERANCE:
        found.append(Difference(f"{name}.saturation", f"{old.saturation:.3f}", f"{new.saturation:.3f}"))
    return found


def _hue_distance(a: float | None, b: float | None) -> float:
    return 0.0 if a is None or b is None else abs((a - b + 180.0) % 360.0 - 180.0)


def _metres(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v:.4f}" for v in values) + ") m"


def task_differences(recorded: Task, computed: Task) -> tuple[Difference, ...]:
    """What differs between two readings of the same path."""
    if len(recorded.steps) != len(computed.steps):
        return (Difference("steps", str(len(recorded.steps)), str(len(computed.steps))),)
    found = []
    for old, new in zip(recorded.steps, computed.steps, strict=True):
        for field in ("kind", "primary_object", "runner_up"):
            if getattr(old, field) != getattr(new, field):
                found.append(
                    Difference(f"step {old.index}.{field}", str(getattr(old, field)), str(getattr(new, field)))
                )
        for field, tolerance in (("distance", LENGTH_TOLERANCE), ("end", TIME_TOLERANCE)):
            before, after = getattr(old, field), getattr(new, field)
            if not math.isclose(before, after, rel_tol=0.0, abs_tol=tolerance):
                found.append(Difference(f"step {old.index}.{field}", f"{before:.4f}", f"{after:.4f}"))
    return tuple(found)


def with_value(
    recorded: Sequence[Recorded[Value]], entry: Recorded[Value], value: Value
) -> tuple[Recorded[Value], ...]:
    """The list with one value exchanged; stamps stay, so whoever names it as an input finds the new one."""
    return tuple(replace(r, value=value) if r is entry else r for r in recorded)


def with_source(session: RecordedSession, old: Scene, new: Scene) -> RecordedSession:
    """The session with another source scene in every task that was read over the old one."""

    def over(task: Task) -> Task:
        known = all(step.primary_object in new.ids for step in task.steps)
        return replace(task, source=new) if known and task.source.stamp == old.stamp else task

    return replace(session, tasks=tuple(replace(t, value=over(t.value)) for t in session.tasks))
