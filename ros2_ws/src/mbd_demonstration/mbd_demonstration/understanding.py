"""What a trajectory and a gripper's reading say together: by one clock, as a task, with all that was noticed."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.objects import Scene
from mbd_model.task import Task

from mbd_demonstration.clocks.skew import find_skew, shifted
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import GripperReading
from mbd_demonstration.segmentation import SegmentationProgress, segment
from mbd_demonstration.trajectory import ToolTrajectory


def in_tool_time(reading: GripperReading, trajectory: ToolTrajectory) -> tuple[GripperReading, tuple[str, ...]]:
    """The reading by the tool's clock, and a sentence when the gripper's tells another time, or may."""
    skew = find_skew(trajectory, reading.events)
    if skew.by is not None:
        note = (
            f"the gripper's stamps are {abs(skew.by):.1f} s {'behind' if skew.by > 0.0 else 'ahead of'} the tool's: of "
            f"{len(reading.events)} gripper events {skew.moving} happen while the tool travels, and none, or hardly "
            "one, when they are moved by that; they were"
        )
        return replace(reading, events=shifted(reading.events, skew.by)), (note,)
    if skew.moving:
        note = (
            f"the tool travels at {skew.moving} of {len(reading.events)} gripper events: is the gripper's clock off "
            "the tool's? By how much is not certain, so nothing was moved"
        )
        return reading, (note,)
    return reading, ()


def understood(
    trajectory: ToolTrajectory,
    reading: GripperReading,
    scene: Scene,
    *,
    stamp: float,
    config: StepSegmentationConfig | None = None,
    so_far: SegmentationProgress | None = None,
    notes: tuple[str, ...] = (),
) -> Task:
    """The task of a trajectory and what the gripper did, with all that was no step among its problems; see segment.

    ``notes`` about the recording itself, such as its stamps, come after those.
    """
    task = segment(
        trajectory,
        reading.events,
        scene,
        stamp=stamp,
        config=config,
        so_far=so_far,
        started_closed=reading.started_closed,
    )
    task = _with_half_closings(task, reading, float(trajectory.stamps[0]))
    return replace(task, problems=task.problems + notes + reading.notes)


def _with_half_closings(task: Task, reading: GripperReading, begin: float) -> Task:
    """The task with each half-closing of the finger joint among its problems; ``begin`` is the recording's [s]."""
    stated = tuple(
        f"at {stamp - begin:.1f} s the gripper closed to {closure:.0%} only and opened again at once: not a step "
        "(it took hold of something only if it rests there for finger_rest)"
        for stamp, closure in reading.half_closings
    )
    return replace(task, problems=task.problems + stated)
