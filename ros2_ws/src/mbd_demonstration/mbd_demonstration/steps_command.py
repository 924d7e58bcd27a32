"""``steps RECORDING [--scene SCENE.yaml]``: what a recorded demonstration shows."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero
from mbd_model.errors import MbdError
from mbd_model.task import Task

from mbd_demonstration.clocks.stamps import held
from mbd_demonstration.files.bounded_reading import read_bounded
from mbd_demonstration.files.recording_formats import ROBOMIMIC_RATE, Selection, read_any
from mbd_demonstration.files.steps_plot import draw
from mbd_demonstration.finger_joint import GripperReading, Polarity, read_gripper
from mbd_demonstration.parameters import DEMONSTRATION, demonstration_config
from mbd_demonstration.recording_files import GRIPPER_COLUMN, RecordedColumns, read_scene
from mbd_demonstration.trajectory import ToolTrajectory
from mbd_demonstration.understanding import in_tool_time, understood

UNUSABLE = 2
# Parameters of the node that say where its input comes from or where its output goes: a file says that itself.
OF_THE_NODE = ("gripper_source", "finger_joints", "tool_pose", "joint_state", "state_dir")
SHORT = {"finger_polarity": "--polarity", "finger_open_level": "--open-level", "finger_closed_level": "--closed-level"}


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
    needed = np.column_stack([columns.stamps, columns.gripper])
    if np.isfinite(columns.positions).any():  # else the layout holds no tool poses
        needed = np.column_stack([needed, columns.positions, columns.quaternions])
    usable = np.isfinite(needed).all(axis=1)
    if not usable.all():
        yield f"note: {int((~usable).sum())} of {usable.size} rows lack a number; what they lack is left out"


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(prog="steps", description="Print the steps of a recorded demonstration.")
    parser.add_argument(
        "recording",
        type=Path,
        help="CSV or NPZ with t, x, y, z, qw, qx, qy, qz, gripper; a rosbag; LeRobot's .parquet; robomimic's .hdf5",
    )
    parser.add_argument("--scene", type=Path, help="YAML of the source objects; without it, gripper events only")
    parser.add_argument("--plot", type=Path, metavar="PNG", help="draw gripper, speed, height, events and steps")
    parser.add_argument(
        "--fingers",
        nargs="+",
        default=[],
        metavar="NAME",
        help=f"columns or joints of the gripper (default: {GRIPPER_COLUMN}, or what is named like a finger)",
    )
    parser.add_argument("--episode", type=int, default=0, help="which recording of the file, from 0 (default: 0)")
    parser.add_argument(
        "--rate", type=above_zero, default=ROBOMIMIC_RATE, help="[Hz] of a layout without stamps (default: %(default)s)"
    )
    for spec in DEMONSTRATION.specs:
        if spec.name in OF_THE_NODE:
            continue
        flags = ["--" + spec.name.replace("_", "-"), *([SHORT[spec.name]] if spec.name in SHORT else [])]
        if spec.name == "finger_polarity":
            parser.add_argument(
                *flags,
                dest=spec.name,
                choices=[str(p) for p in Polarity],
                default=str(Polarity.LARGER_OPEN),
                help="what a larger gripper number means (default: an opening)",
            )
        else:
            unit = f" [{spec.unit}]" if spec.unit else ""
            parser.add_argument(
                *flags,
                dest=spec.name,
                type=float,
                default=spec.default,
                help=f"{spec.description}{unit} (default: %(default)s)",
            )
    return parser


def run(words: Sequence[str] | None = None) -> str:
    """What the tool prints.

    Raises:
        MbdError: a file or a setting that cannot be used.
    """
    options = _parser().parse_args(words)
    if not options.rate > 0.0:
        raise MbdError(f"--rate is {options.rate}; expected samples a second, > 0")
    given = {s.name: getattr(options, s.name) for s in DEMONSTRATION.specs if s.name not in OF_THE_NODE}
    config = demonstration_config(DEMONSTRATION.values(given))
    selection = Selection(tuple(options.fingers), options.episode, options.rate)
    columns = read_bounded(read_any, options.recording, selection)
    reading = read_gripper(columns.stamps, columns.gripper, config.finger)
    has_poses = bool(np.isfinite(columns.positions).all(axis=1).any())
    path = ToolTrajectory.from_samples(columns.stamps, columns.positions, columns.quaternions) if has_poses else None
    notes = columns.notes
    if path is not None:
        reading, skewed = in_tool_time(reading, path)
        notes += (*skewed, *held(path.stamps, path.positions, "the tool pose"))
    task = None
    if options.scene is None:
        lines = [*events_table(reading), *(f"note: {note}" for note in (*notes, *reading.notes))]
    elif path is None:
        raise MbdError(f"{options.recording} holds no tool poses: without --scene its gripper events can be read")
    else:
        scene = read_bounded(read_scene, options.scene)
        end = float(path.stamps[-1])
        task = understood(path, reading, scene, stamp=end, config=config.segmentation, notes=notes)
        lines = list(steps_table(task))
    if options.plot is not None:
        title = f"{options.recording.resolve().parent.name}/{options.recording.name}"
        draw(options.plot, title, columns, reading, trajectory=path, task=task)
    return "\n".join([*lines, *lost_rows(columns)])


def main() -> None:
    """Print, or report why not and end with 2."""
    try:
        sys.stdout.write(run() + "\n")
    except MbdError as error:
        sys.stderr.write(f"steps: {error}\n")
        sys.exit(UNUSABLE)
