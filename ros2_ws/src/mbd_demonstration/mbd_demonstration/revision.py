"""What a teacher corrects in a recorded task: one pure function for each correction, and where a recording goes on."""

from __future__ import annotations

import dataclasses

import numpy as np
from mbd_model.boxes import outside_box
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


def deleted(task: Task, index: int, stamp: float) -> Task:
    """The task without one step and what belongs to it: a PICK goes with its PLACE, a PLACE with its PICK.

    The last step alone may go without its other half: an object that is still held is placed again.

    Args:
        task: as recorded or corrected before.
        index: 0-based, of the step.
        stamp: time of the correction [s].

    Raises:
        MbdError: there is no such step.
    """
    step = _step(task, index)
    if index == len(task.steps) - 1:
        return without_last_step(task, stamp)
    first, last = carry_of(task, index)
    kept = [s for k, s in enumerate(task.steps) if not first <= k <= last]
    what = f"step {index + 1} ({step.kind.name} {step.primary_object}) was deleted by the teacher"
    return _again(task, kept, what, stamp)


def moved(task: Task, index: int, to: int, stamp: float) -> Task:
    """The task with the pick and place that a step belongs to in another place of the order.

    Args:
        task: as recorded or corrected before.
        index: 0-based, of the step.
        to: 0-based, of a step before whose pick it is to come; the number of steps: to the end.
        stamp: time of the correction [s].

    Raises:
        MbdError: there is no such step.
    """
    step = _step(task, index)
    first, last = carry_of(task, index)
    target = len(task.steps) if to == len(task.steps) else carry_of(task, to)[0]
    carried = list(task.steps[first : last + 1])
    before = [s for k, s in enumerate(task.steps) if k < target and not first <= k <= last]
    after = [s for k, s in enumerate(task.steps) if k >= target and not first <= k <= last]
    what = f"step {index + 1} ({step.kind.name} {step.primary_object}) was moved by the teacher"
    return _again(task, [*before, *carried, *after], what, stamp)


def with_object(task: Task, index: int, object_id: str, stamp: float) -> Task:
    """The task with another primary object of one step; the teacher's word leaves no doubt about it.

    Raises:
        MbdError: there is no such step, or no such object in the source scene.
    """
    step = _step(task, index)
    if object_id not in task.source.ids:
        raise MbdError(f"the source scene has no object '{object_id}'; it has {', '.join(task.source.ids)}")
    if object_id == step.primary_object:
        raise MbdError(f"'{object_id}' is the primary object of step {index + 1} already")
    first, last = carry_of(task, index)
    where = _where(task, index)[object_id].centroid
    x, y, z = np.array(step.tool_position) - np.array(where)
    distance = float(np.linalg.norm(outside_box(step.tool_position, _where(task, index)[object_id])))
    changed = dataclasses.replace(
        step,
        primary_object=object_id,
        distance=distance,
        runner_up=step.primary_object,
        runner_up_distance=step.distance,
        offset=(float(x), float(y), float(z)),
        doubt=0.0,
    )
    steps = list(task.steps)
    steps[index] = changed
    # Put on the table, a PLACE names the object it holds: that follows its PICK.
    put_on_table = last != first and task.steps[last].primary_object == step.primary_object
    if index == first and put_on_table:
        steps[last] = dataclasses.replace(task.steps[last], primary_object=object_id)
    what = (
        f"the primary object of step {index + 1} ({step.kind.name}) was changed by the teacher from "
        f"'{step.primary_object}' to '{object_id}'"
    )
    return _again(task, steps, what, stamp)


def split(task: Task, index: int, tool: ToolPose, at: float, stamp: float) -> Task:
    """The task with one carry made two: the object is put down on the table, and taken again, on the way.

    Args:
        task: as recorded or corrected before.
        index: 0-based, of the PLACE that ends the carry.
        tool: where the tool was then [m, robot base frame].
        at: when [s], between the carry's PICK and PLACE.
        stamp: time of the correction [s].

    Raises:
        MbdError: there is no such step, it is no PLACE, or the time is not on its way.
    """
    step = _step(task, index)
    first, last = carry_of(task, index)
    if step.kind is not StepKind.PLACE or first == last:
        raise MbdError(f"step {index + 1} is a {step.kind.name}: only a PLACE after its PICK can be split")
    pick = task.steps[first]
    if not pick.end < at < step.end:
        raise MbdError(f"{at:.1f} s is not between the PICK ({pick.end:.1f} s) and the PLACE ({step.end:.1f} s)")
    position = (float(tool.position[0]), float(tool.position[1]), float(tool.position[2]))
    qx, qy, qz, qw = map(float, tool.quaternion)
    down = dataclasses.replace(
        pick,
        kind=StepKind.PLACE,
        start=pick.end,
        end=at,
        tool_position=position,
        tool_quaternion=(qx, qy, qz, qw),
        doubt=0.0,
    )
    again = dataclasses.replace(down, kind=StepKind.PICK, start=at)
    steps = [*task.steps[: first + 1], down, again, *task.steps[first + 1 :]]
    what = f"step {index + 1} (PLACE {step.primary_object}) was split by the teacher at {at:.1f} s"
    return _again(task, steps, what, stamp)


def joined_steps(task: Task, index: int, stamp: float) -> Task:
    """The task without a PLACE and the PICK after it, of one object: it was carried on.

    Raises:
        MbdError: there is no such step, or the next one does not take the same object again.
    """
    step = _step(task, index)
    after = task.steps[index + 1] if index + 1 < len(task.steps) else None
    held = task.steps[carry_of(task, index)[0]].primary_object
    if step.kind is not StepKind.PLACE or after is None or after.primary_object != held:
        raise MbdError(
            f"step {index + 1} ({step.kind.name} {step.primary_object}) is not put down and taken again: "
            "join a PLACE whose next step is the PICK of the same object"
        )
    kept = [*task.steps[:index], *task.steps[index + 2 :]]
    return _again(
        task, kept, f"steps {index + 1} and {index + 2} were joined by the teacher: '{held}' was carried on", stamp
    )


def shown_again_from(task: Task, index: int) -> SegmentationProgress:
    """Where a recording goes on that shows a step and all after it again.

    The objects are where the complete task left them, as they truly are now.

    Raises:
        MbdError: there is no such step.
    """
    step = _step(task, index)
    what = f"steps from {index + 1} ({step.kind.name} {step.primary_object}) on were recorded again by the teacher"
    kept = dataclasses.replace(task, steps=task.steps[:index], problems=(*task.problems, what))
    return dataclasses.replace(resume(kept), workspace=resume(task).workspace)


def carry_of(task: Task, index: int) -> tuple[int, int]:
    """(first, last) 0-based: the PICK and PLACE a step belongs to; one number twice where the other half lacks."""
    step = _step(task, index)
    if step.kind is StepKind.PICK:
        has_place = index + 1 < len(task.steps) and task.steps[index + 1].kind is StepKind.PLACE
        return index, index + int(has_place)
    has_pick = index > 0 and task.steps[index - 1].kind is StepKind.PICK
    return index - int(has_pick), index


def _step(task: Task, index: int) -> TaskStep:
    if not 0 <= index < len(task.steps):
        raise MbdError(f"there is no step {index + 1}: the task has {len(task.steps)}")
    return task.steps[index]


def _where(task: Task, index: int) -> TrackedObjects:
    """Where the objects are at the end of a step: a PLACE has put its object down."""
    return resume(dataclasses.replace(task, steps=task.steps[: index + 1], open_ends=())).workspace


def _again(task: Task, steps: list[TaskStep], what: str, stamp: float) -> Task:
    """The task with other steps, numbered again, and what was done among its problems."""
    numbered = tuple(dataclasses.replace(s, index=k) for k, s in enumerate(steps))
    return dataclasses.replace(task, steps=numbered, problems=(*task.problems, what), stamp=stamp)
