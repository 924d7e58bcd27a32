"""From a tool trajectory and gripper events to PICK and PLACE steps with their primary objects (paper sec. 4.2).

Each closing ends a PICK, each opening a PLACE. The primary object of a PICK is the object nearest to the tool; of a
PLACE it is what the held object was put onto or into, or the held object itself when it was put on the table. What
cannot be a step is stated among the task's problems and guessed at nowhere.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
from mbd_model.objects import Scene
from mbd_model.task import StepKind, Task, TaskStep
from numpy.typing import NDArray

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.geometry.judging import IN_THE_AIR, PUSHED, REGRASPED, Hold, pushed, remarks, tie
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose, ToolTrajectory

BEGAN_CLOSED = (
    "the recording began with the gripper closed: what it held is not known, and letting go of it is no step "
    "(open the gripper before a demonstration starts)"
)
NEVER_CLOSED = "the gripper never closed: no object was picked up; say 'close' (or close the gripper) at each object"


@dataclasses.dataclass(frozen=True)
class SegmentationProgress:
    """A demonstration understood so far.

    Attributes:
        begin: start of the recording [s]; problems give times from it.
        workspace: where the objects are now.
        steps: recorded so far, in order.
        problems: what was no step, one sentence each.
        closed: whether the gripper is closed.
        hold: what it holds.
        awaited: object whose PICK is among the steps but which is not held: a redone PLACE begins by taking it again.
        last: end of the last step [s].
    """

    begin: float
    workspace: TrackedObjects
    steps: tuple[TaskStep, ...] = ()
    problems: tuple[str, ...] = ()
    closed: bool = False
    hold: Hold | None = None
    awaited: str = ""
    last: float = -math.inf

    def with_problem(self, stamp: float, sentence: str, **changes: object) -> SegmentationProgress:
        """This, with one more problem that happened at ``stamp`` [s], and other fields changed."""
        text = f"at {stamp - self.begin:.1f} s {sentence}"
        return dataclasses.replace(self, problems=(*self.problems, text), **changes)  # type: ignore[arg-type]  # **object


def segment(
    trajectory: ToolTrajectory,
    events: Iterable[GripperEvent],
    scene: Scene,
    *,
    stamp: float,
    config: StepSegmentationConfig | None = None,
    so_far: SegmentationProgress | None = None,
    started_closed: bool = False,
) -> Task:
    """The task one demonstration shows.

    Args:
        trajectory: path of the tool.
        events: what the gripper did, in any order.
        scene: the source scene, seen before the demonstration.
        stamp: time at which the task is complete [s].
        config: distances that decide.
        so_far: steps of an earlier recording that this one goes on from.
        started_closed: the gripper was closed as the recording began, on what no one knows.

    Returns:
        The steps in order, and a sentence for everything that is no step; a task without steps states why.
    """
    config = config or StepSegmentationConfig()
    begin = float(trajectory.stamps[0])
    progress = so_far or SegmentationProgress(begin, TrackedObjects.before(scene))
    progress = dataclasses.replace(progress, begin=begin, last=max(progress.last, begin), closed=started_closed)
    if started_closed:
        progress = dataclasses.replace(progress, problems=(*progress.problems, BEGAN_CLOSED))
    for event in sorted(events, key=lambda e: e.stamp):
        progress = advance(progress, event, trajectory, config)
    return finish(progress, scene, stamp)


def finish(progress: SegmentationProgress, scene: Scene, stamp: float) -> Task:
    """The task of a demonstration that ended, ``stamp`` [s], with what it leaves open among the problems."""
    problems = progress.problems
    open_ends: tuple[int, ...] = ()
    if progress.hold or progress.awaited:
        held = progress.hold.object_id if progress.hold else progress.awaited
        open_ends = (len(problems),)
        problems += (f"the demonstration ended while holding '{held}': its last pick has no place",)
    if not progress.steps:
        problems += (NEVER_CLOSED,) if not progress.problems else ()
    return Task(scene, progress.steps, problems, stamp, open_ends)


def advance(
    progress: SegmentationProgress, event: GripperEvent, trajectory: ToolTrajectory, config: StepSegmentationConfig
) -> SegmentationProgress:
    """The demonstration after one more gripper event."""
    gap = trajectory.gap_at(event.stamp)
    if gap > config.max_pose_gap:
        return progress.with_problem(
            event.stamp, f"the gripper {_verb(event)}, but the nearest tool pose is {gap:.1f} s away: not a step"
        )
    if event.action is GripperAction.CLOSE:
        return _close(progress, event, trajectory, config)
    return _open(progress, event.stamp, trajectory, config)


def _close(
    progress: SegmentationProgress,
    event: GripperEvent,
    trajectory: ToolTrajectory,
    config: StepSegmentationConfig,
) -> SegmentationProgress:
    """The gripper closed: a PICK of the nearest object in reach."""
    stamp, tool = event.stamp, trajectory.pose_at(event.stamp)
    earlier = trajectory.pose_at(stamp - event.unsure) if event.unsure else None
    if progress.closed:
        return progress.with_problem(stamp, "the gripper closed twice: it was closed already, so this is no step")
    order = progress.workspace.by_distance(tool.position)
    if earlier is not None and order:
        before = progress.workspace.by_distance(earlier.position)
        # A hand closes at things, and lifts what it holds, not what it is about to hold.
        lifted = before[0] == order[0] and earlier.position[2] < tool.position[2]
        if before[0][0] < order[0][0] or lifted:
            order, tool = before, earlier
    if not order or order[0][0] > config.grasp_reach:
        nearest = f"the nearest object, '{order[0][1]}', is {order[0][0]:.2f} m away" if order else "there is no object"
        return progress.with_problem(stamp, f"the gripper closed on nothing: {nearest}", closed=True)
    if order[0][1] == progress.awaited:
        hold = Hold(progress.awaited, stamp, tool, event.level, order[0][0], taken_again=True)
        return dataclasses.replace(progress, closed=True, hold=hold, awaited="")
    if progress.awaited:
        progress = progress.with_problem(stamp, f"'{progress.awaited}' was picked up and never placed", awaited="")
    doubt = tie(progress.workspace, tool, order[:2], config)
    step = _step(progress, StepKind.PICK, stamp, tool, order, doubt=doubt)
    hold = Hold(step.primary_object, stamp, tool, event.level, order[0][0])
    return dataclasses.replace(progress, closed=True, hold=hold, steps=(*progress.steps, step), last=stamp)


def _open(
    progress: SegmentationProgress, stamp: float, trajectory: ToolTrajectory, config: StepSegmentationConfig
) -> SegmentationProgress:
    """The gripper opened: a PLACE of what it held."""
    if not progress.closed:
        return progress.with_problem(stamp, "the gripper opened twice: it was open already, so this is no step")
    if progress.hold is None:
        return dataclasses.replace(progress, closed=False)  # the end of an empty grasp, stated when it began
    held, tool = progress.hold, trajectory.pose_at(stamp)
    # What stands somewhere cannot sink: a tool that only went down slid along it, as an arm does that sags.
    if trajectory.farthest_from(held.grasp.position, held.stamp, stamp, down=held.taken_again) < config.regrasp_travel:
        return _let_go(progress, held, stamp)
    if pushed(progress.workspace, held, trajectory, stamp, config):
        return _let_go(progress, held, stamp, PUSHED)
    moved = progress.workspace.carried(held.object_id, held.grasp, tool)
    receivers = moved.receivers(held.object_id, config)
    order = moved.by_distance(tool.position, without=moved.load(held.object_id))
    onto = [entry for entry in order if entry[1] in receivers]
    fall = moved.fall(held.object_id, config.onto_margin)
    if not onto and fall > config.drop:
        return dataclasses.replace(progress, workspace=moved, hold=None, awaited=held.object_id).with_problem(
            stamp, IN_THE_AIR.format(held.object_id, fall), closed=False
        )
    doubt = tie(moved, tool, onto[:2], config)
    for remark in remarks(held, trajectory, stamp, 0.0 if onto else fall, config):
        progress = progress.with_problem(stamp, remark)
    if onto:
        moved = moved.put_onto(held.object_id, onto[0][1])
    else:
        onto = [entry for entry in moved.by_distance(tool.position) if entry[1] == held.object_id]
    ranked = [*onto, *(entry for entry in order if entry not in onto)]
    progress = dataclasses.replace(progress, closed=False, hold=None, workspace=moved)
    step = _step(progress, StepKind.PLACE, stamp, tool, ranked, doubt=doubt)
    return dataclasses.replace(progress, steps=(*progress.steps, step), last=stamp)


def _let_go(progress: SegmentationProgress, held: Hold, stamp: float, why: str = "") -> SegmentationProgress:
    """An object let go where it stood was grasped again (or was pushed): its pick does not count."""
    picked_now = bool(progress.steps) and progress.steps[-1].end == held.stamp
    steps = progress.steps[:-1] if picked_now else progress.steps
    return progress.with_problem(
        stamp,
        (why or REGRASPED).format(held.object_id),
        closed=False,
        hold=None,
        steps=steps,
        awaited="" if picked_now else held.object_id,
        last=steps[-1].end if steps else progress.begin,
    )


def _step(
    progress: SegmentationProgress,
    kind: StepKind,
    stamp: float,
    tool: ToolPose,
    order: list[tuple[float, str]],
    *,
    doubt: float,
) -> TaskStep:
    """A step that ended with the tool here; ``order`` is (distance [m], id), the primary object first."""
    distance, primary = order[0]
    runner_up_distance, runner_up = order[1] if len(order) > 1 else (math.inf, "")
    return TaskStep(
        index=len(progress.steps),
        kind=kind,
        primary_object=primary,
        distance=distance,
        runner_up=runner_up,
        runner_up_distance=runner_up_distance,
        start=progress.last,
        end=stamp,
        tool_position=_triple(tool.position),
        tool_quaternion=(*_triple(tool.quaternion[:3]), float(tool.quaternion[3])),
        offset=_triple(tool.position - np.asarray(progress.workspace[primary].centroid)),
        doubt=doubt,
    )


def _triple(values: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def _verb(event: GripperEvent) -> str:
    return "closed" if event.action is GripperAction.CLOSE else "opened"
