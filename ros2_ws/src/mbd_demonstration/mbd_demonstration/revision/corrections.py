"""What a teacher corrects in a recorded task: one pure function for each correction."""

from __future__ import annotations

import dataclasses

import numpy as np
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.geometry.boxes import outside_box
from mbd_model.task import StepKind, Task, TaskStep

from mbd_demonstration.revision.resuming import resume, step_of, without_last_step
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose, ToolTrajectory


def corrected(task: Task, correction: StepCorrection, now: float, path: ToolTrajectory | None) -> Task:
    """The task with one step corrected, but for RERECORD, which needs a recording.

    Args:
        task: as it is.
        correction: what to change.
        now: time of the correction [s].
        path: of the tool as the task was recorded, if that is known.

    Raises:
        MbdError: it cannot be corrected so.
    """
    index = correction.step
    if correction.kind is CorrectionKind.DELETE:
        return deleted(task, index, now)
    if correction.kind is CorrectionKind.MOVE:
        return moved(task, index, correction.to, now)
    if correction.kind is CorrectionKind.CHANGE_OBJECT:
        return with_object(task, index, correction.object_id, now)
    if correction.kind is CorrectionKind.JOIN:
        return joined_steps(task, index, now)
    if correction.kind is CorrectionKind.SPLIT:
        if path is None:
            raise MbdError("where the tool went is no longer known: its recording was not kept (is state_dir set?)")
        if not path.stamps[0] <= correction.at <= path.stamps[-1]:
            raise MbdError(f"where the tool was at {correction.at:.1f} s is no longer known: it was recorded before")
        return split(task, index, path.pose_at(correction.at), correction.at, now)
    raise MbdError(f"{correction.kind.name} is no change of what was recorded: it records")


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
    step = step_of(task, index)
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
    step = step_of(task, index)
    first, last = carry_of(task, index)
    target = len(task.steps) if to == len(task.steps) else carry_of(task, to)[0]
    carried = list(task.steps[first : last + 1])
    before = [s for k, s in enumerate(task.steps) if k < target and not first <= k <= last]
    after = [s for k, s in enumerate(task.steps) if k >= target and not first <= k <= last]
    what = f"step {index + 1} ({step.kind.name} {step.primary_object}) was moved by the teacher"
    return _again(task, [*before, *carried, *after], what, stamp)


def with_object(task: Task, index: int, object_id: str, stamp: float) -> Task:
    """The task with another primary object of one step; the teacher's word leaves no doubt about it.

    The one it has already: that is confirmed, and no longer in doubt.

    Raises:
        MbdError: there is no such step, no such object in the source scene, or nothing to change.
    """
    step = step_of(task, index)
    if object_id not in task.source.ids:
        raise MbdError(f"the source scene has no object '{object_id}'; it has {', '.join(task.source.ids)}")
    if object_id == step.primary_object:
        return _confirmed(task, index, stamp)
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


def _confirmed(task: Task, index: int, stamp: float) -> Task:
    step = task.steps[index]
    if not step.doubt:
        raise MbdError(f"'{step.primary_object}' is the primary object of step {index + 1} already, without a doubt")
    steps = [dataclasses.replace(s, doubt=0.0) if k == index else s for k, s in enumerate(task.steps)]
    what = f"the primary object of step {index + 1} ({step.kind.name}) was confirmed by the teacher: "
    return _again(task, steps, f"{what}'{step.primary_object}'", stamp)


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
    step = step_of(task, index)
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
    step = step_of(task, index)
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


def carry_of(task: Task, index: int) -> tuple[int, int]:
    """(first, last) 0-based: the PICK and PLACE a step belongs to; one number twice where the other half lacks."""
    step = step_of(task, index)
    if step.kind is StepKind.PICK:
        has_place = index + 1 < len(task.steps) and task.steps[index + 1].kind is StepKind.PLACE
        return index, index + int(has_place)
    has_pick = index > 0 and task.steps[index - 1].kind is StepKind.PICK
    return index - int(has_pick), index


def _where(task: Task, index: int) -> TrackedObjects:
    """Where the objects are at the end of a step: a PLACE has put its object down."""
    return resume(dataclasses.replace(task, steps=task.steps[: index + 1], open_ends=())).workspace


def _again(task: Task, steps: list[TaskStep], what: str, stamp: float) -> Task:
    """The task with other steps, numbered again, and what was done among its problems."""
    numbered = tuple(dataclasses.replace(s, index=k) for k, s in enumerate(steps))
    return dataclasses.replace(task, steps=numbered, problems=(*task.problems, what), stamp=stamp)
