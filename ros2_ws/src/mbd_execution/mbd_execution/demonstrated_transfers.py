"""What the demonstration did, as transfers of one object each: how it was grasped, and how it was put where.

The demonstrated steps are played through once more on the source scene (paper sec. 6.5.1: objects that were moved are
followed), because a step's offset means something only with the boxes it was measured between.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose
from mbd_model.objects import Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

from mbd_execution.goals import ToolGoal, goal_of


@dataclass(frozen=True)
class DemonstratedTransfer:
    """One object that was picked up and set down.

    Attributes:
        pick, place: indices of the two steps.
        picked: the source object where it was grasped.
        put: the same object where it was let go.
        receiver: what it was put onto or into, where that was then; None: onto the table.
        grasp, release: the tool when the hand closed and opened.
    """

    pick: int
    place: int
    picked: SceneObject
    put: SceneObject
    receiver: SceneObject | None
    grasp: ToolGoal
    release: ToolGoal


def standing(scene: Scene) -> TrackedObjects:
    """The objects of a scene with the middle of their boxes as their place.

    A centroid is the mean of the visible points, nearer to the camera than the middle; where a scene has only that,
    it is taken as it is.
    """
    return TrackedObjects(tuple(replace(o, centroid=o.box_center or o.centroid) for o in scene.objects))


def transfers(task: Task) -> tuple[DemonstratedTransfer, ...]:
    """The task's transfers in order; a pick that no place follows is none."""
    workspace = standing(task.source)
    done: list[DemonstratedTransfer] = []
    pick: TaskStep | None = None
    for step in task.steps:
        if step.kind is StepKind.PICK:
            pick = step
            continue
        if pick is None:
            continue
        held = pick.primary_object
        before = workspace[held]
        workspace = workspace.carried(held, _pose(pick), _pose(step))
        receiver = None
        if step.primary_object != held:
            receiver = workspace[step.primary_object]
            workspace = workspace.put_onto(held, step.primary_object)
        done.append(
            DemonstratedTransfer(
                pick.index, step.index, before, workspace[held], receiver, _goal(pick), _goal(step)
            )
        )  # fmt: skip
        pick = None
    return tuple(done)


def _pose(step: TaskStep) -> ToolPose:
    return ToolPose(np.array(step.tool_position), np.array(step.tool_quaternion))


def _goal(step: TaskStep) -> ToolGoal:
    return goal_of(step.tool_position, step.tool_quaternion)
