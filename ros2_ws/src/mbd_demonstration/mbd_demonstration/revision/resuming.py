"""Where a recording goes on from a task, some of whose steps are shown again."""

from __future__ import annotations

import dataclasses

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.task import StepKind, Task, TaskStep

from mbd_demonstration.geometry.judging import Hold
from mbd_demonstration.segmentation import SegmentationProgress
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose


def without_last_step(task: Task, stamp: float) -> Task:
    """The task, complete at ``stamp`` [s], without its last step.

    Raises:
        MbdError: it has none.
    """
    if not task.steps:
        raise MbdError("there is no step to drop: the task has none")
    dropped = task.steps[-1]
    problem = f"step {dropped.index + 1} ({dropped.kind.name} {dropped.primary_object}) was dropped by the teacher"
    return dataclasses.replace(task, steps=task.steps[:-1], problems=(*task.problems, problem), stamp=stamp)


def redo_from(task: Task) -> SegmentationProgress:
    """Where a recording goes on that shows the last step again.

    The objects are where the complete task left them: a dropped PLACE has happened, so its object is taken again from
    there (no new step) and placed elsewhere.

    Raises:
        MbdError: there is no step to redo.
    """
    kept = resume(without_last_step(task, task.stamp))
    return dataclasses.replace(kept, workspace=resume(task).workspace)


def resume(task: Task) -> SegmentationProgress:
    """Where a recorded task leaves the workspace, for a recording that goes on from it.

    A task whose last step is a PICK awaits its place: the object is taken again, which is no new step, and placed.
    """
    workspace = TrackedObjects.before(task.source)
    hold: Hold | None = None
    for step in task.steps:
        tool = ToolPose(np.array(step.tool_position), np.array(step.tool_quaternion))
        if step.kind is StepKind.PICK:
            hold = Hold(step.primary_object, step.end, tool)
        elif hold:
            workspace = workspace.carried(hold.object_id, hold.grasp, tool)
            if step.primary_object != hold.object_id:
                workspace = workspace.put_onto(hold.object_id, step.primary_object)
            hold = None
    last = task.steps[-1].end if task.steps else -np.inf
    kept = tuple(p for number, p in enumerate(task.problems) if number not in task.open_ends)
    progress = SegmentationProgress(last, workspace, task.steps, kept, last=last)
    return dataclasses.replace(progress, awaited=hold.object_id if hold else "")


def shown_again_from(task: Task, index: int) -> SegmentationProgress:
    """Where a recording goes on that shows a step and all after it again.

    The objects are where the complete task left them, as they truly are now.

    Raises:
        MbdError: there is no such step.
    """
    step = step_of(task, index)
    what = f"steps from {index + 1} ({step.kind.name} {step.primary_object}) on were recorded again by the teacher"
    kept = dataclasses.replace(task, steps=task.steps[:index], problems=(*task.problems, what))
    return dataclasses.replace(resume(kept), workspace=resume(task).workspace)


def step_of(task: Task, index: int) -> TaskStep:
    """The step of that 0-based number; raises MbdError when there is none."""
    if not 0 <= index < len(task.steps):
        raise MbdError(f"there is no step {index + 1}: the task has {len(task.steps)}")
    return task.steps[index]
