"""A recording as a picture: the gripper, the tool's speed and height, and the events and steps read off them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mbd_model.task import StepKind, Task

from mbd_demonstration.clocks.skew import speeds
from mbd_demonstration.finger_joint import GripperReading
from mbd_demonstration.gripper import GripperAction
from mbd_demonstration.recording_files import RecordedColumns, RecordingFileError
from mbd_demonstration.trajectory import ToolTrajectory

CLOSES, OPENS, GRIPPER, TOOL = "#b2182b", "#2166ac", "#333333", "#1b7837"


def draw(
    path: Path,
    title: str,
    columns: RecordedColumns,
    reading: GripperReading,
    *,
    trajectory: ToolTrajectory | None = None,
    task: Task | None = None,
) -> None:
    """Write a PNG (or what the name's ending says).

    Args:
        path: of the picture.
        title: above the picture.
        columns: of the recording.
        reading: its gripper events.
        trajectory: path of the tool; None: not recorded.
        task: its steps; None: without a scene there are none.

    Raises:
        RecordingFileError: the picture cannot be written there.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    begin = float(np.nanmin(columns.stamps))
    rows = 1 if trajectory is None else 3
    figure = Figure(figsize=(11, 2.2 + 1.9 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = np.atleast_1d(figure.subplots(rows, 1, sharex=True))
    axes[0].plot(columns.stamps - begin, columns.gripper, color=GRIPPER, lw=1.0)
    axes[0].set_ylabel("gripper [as recorded]")
    if trajectory is not None:
        grid, share = speeds(trajectory)
        axes[1].plot(grid - begin, share, color=TOOL, lw=1.0)
        axes[1].set_ylabel("speed of the tool\n[of its travelling speed]")
        axes[2].plot(trajectory.stamps - begin, trajectory.positions[:, 2], color=TOOL, lw=1.0)
        axes[2].set_ylabel("height of the tool [m]")
    for axis in axes:
        for event in reading.events:
            closes = event.action is GripperAction.CLOSE
            axis.axvline(event.stamp - begin, color=CLOSES if closes else OPENS, lw=1.2, ls="-" if closes else "--")
        for stamp, _ in reading.half_closings:
            axis.axvline(stamp - begin, color="#999999", lw=1.0, ls=":")
        axis.margins(x=0.01)
        axis.spines[["top", "right"]].set_visible(False)
    top = axes[0].get_xaxis_transform()
    if task is None:
        for event in reading.events:
            axes[0].text(event.stamp - begin, 1.02, event.action.name.lower(), transform=top, rotation=35, fontsize=9)
    else:
        for step in task.steps:
            color = CLOSES if step.kind is StepKind.PICK else OPENS
            words = f"{step.index + 1} {step.kind.name} {step.primary_object}" + (" ?" if step.doubt > 0.05 else "")
            axes[0].text(step.end - begin, 1.02, words, transform=top, rotation=35, fontsize=9, color=color)
    axes[-1].set_xlabel(
        "time from the beginning of the recording [s]   (solid: closes, dashed: opens, dotted: half closed)"
    )
    figure.suptitle(title, fontsize=10)
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as error:  # no such folder, an ending that matplotlib cannot write
        reason = str(error).splitlines()[0]
        raise RecordingFileError(f"cannot draw into {path}: {reason}; give a .png in a folder that exists") from error
