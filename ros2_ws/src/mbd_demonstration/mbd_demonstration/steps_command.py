"""``steps TRAJ.csv [--scene SCENE.yaml]``: what a recorded demonstration shows."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.task import Task

from mbd_demonstration.finger_joint import FingerJointConfig, GripperReading, Polarity, read_gripper
from mbd_demonstration.recording import understood
from mbd_demonstration.recording_files import GRIPPER_COLUMN, RecordedColumns, read_recording, read_scene
from mbd_demonstration.trajectory import ToolTrajectory

UNUSABLE = 2


def events_table(reading: GripperReading) -> Iterable[str]:
    """One line for each gripper event and half-closing."""
    yield f"{len(reading.events)} gripper events"
    yield from (f"{event.stamp:9.3f} s  {event.action.name.lower()}" for event in reading.events)
    yield from (f"{stamp:9.3f} s  half-closing to {closure:.0%}" for stamp, closure in reading.half_closings)


def steps_table(task: Task) -> Iterable[str]:
    """One line for each step, with the runner-up and the margin to it, and one for each problem."""
    yield f"{len(task.steps)} steps"
    yield f"{'step':>4}  {'end [s]':>9}  {'act':<5}  {'object':<10}  {'at [m]':>7}  {'runner-up':<10}  margin [m]"
    for s in task.steps:
        margin = f"{s.runner_up_distance - s.distance:10.3f}" if s.runner_up else ""
        yield (
            f"{s.index + 1:>4}  {s.end:9.3f}  {s.kind.name:<5}  {s.primary_object:<10}  {s.distance:7.3f}  "
            f"{s.runner_up or '-':<10}  {margin}"
        ).rstrip()
    yield from (f"note: {problem}" for problem in task.problems)


def lost_rows(columns: RecordedColumns) -> Iterable[str]:
    """A line about rows that lack numbers, when there are any."""
    poses = np.column_stack([columns.stamps, columns.positions, columns.quaternions])
    usable = np.isfinite(poses).all(axis=1) & np.isfinite(columns.gripper)
    if not usable.all():
        yield f"note: {int((~usable).sum())} of {usable.size} rows lack a number; what they lack is left out"


def run(words: Sequence[str] | None = None) -> str:
    """What the tool prints.

    Raises:
        MbdError: a file that cannot be used.
    """
    parser = argparse.ArgumentParser(prog="steps", description="Print the steps of a recorded demonstration.")
    parser.add_argument("recording", type=Path, help="CSV with t, x, y, z, qw, qx, qy, qz, gripper")
    parser.add_argument("--scene", type=Path, help="YAML of the source objects; without it, gripper events only")
    parser.add_argument(
        "--polarity",
        type=Polarity,
        choices=list(Polarity),
        default=Polarity.LARGER_OPEN,
        help="what a larger gripper number means (default: an opening)",
    )
    parser.add_argument(
        "--fingers",
        nargs="+",
        default=[GRIPPER_COLUMN],
        metavar="COLUMN",
        help=f"columns whose mean is the gripper's position (default: {GRIPPER_COLUMN})",
    )
    for name in ("open", "closed"):
        parser.add_argument(
            f"--{name}-level",
            type=float,
            default=math.nan,
            help=f"gripper position of the {name} hand; both or neither: then they are learned from the recording",
        )
    options = parser.parse_args(words)
    columns = read_recording(options.recording, options.fingers)
    finger = FingerJointConfig(options.polarity, options.open_level, options.closed_level)
    reading = read_gripper(columns.stamps, columns.gripper, finger)
    if options.scene is None:
        return "\n".join([*events_table(reading), *lost_rows(columns)])
    path = ToolTrajectory.from_samples(columns.stamps, columns.positions, columns.quaternions)
    task = understood(path, reading, read_scene(options.scene), stamp=float(path.stamps[-1]))
    return "\n".join([*steps_table(task), *lost_rows(columns)])


def main() -> None:
    """Print, or report why not and end with 2."""
    try:
        sys.stdout.write(run() + "\n")
    except MbdError as error:
        sys.stderr.write(f"steps: {error}\n")
        sys.exit(UNUSABLE)
