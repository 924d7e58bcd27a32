"""Recordings read from their files: one that was cut off by the end of its node's process, and the complete one."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from mbd_model.errors import MbdError
from mbd_model.ros.conversions import task_from_msg
from mbd_model.task import Task
from mbd_msgs.msg import Task as TaskMsg
from rclpy.serialization import deserialize_message

from mbd_demonstration.journal import completed, found
from mbd_demonstration.recording import Recording
from mbd_demonstration.revision.resuming import shown_again_from
from mbd_demonstration.trajectory import ToolTrajectory


class KeptRecording(NamedTuple):
    """A recording from its file.

    Attributes:
        recording: all that was recorded.
        task: it began from.
        again: first of its steps that were shown again (0-based), -1 for none.
        cuts: last tool pose before each earlier end of a node that recorded it [s].
    """

    recording: Recording
    task: Task
    again: int
    cuts: tuple[float, ...]


def kept_recording(path: Path, wanted: tuple[str, ...]) -> KeptRecording | None:
    """What a file holds; None: there is none.

    Args:
        path: of the file.
        wanted: names of the finger joints.

    Raises:
        MbdError: the file holds what cannot be read.
    """
    try:
        cut = found(path)
    except OSError as error:
        raise MbdError(f"{path} cannot be read: {error.strerror}") from error
    if cut is None and path.exists():
        raise MbdError(f"{path} is no recording that this version kept")
    if cut is None:
        return None
    try:
        task = task_from_msg(deserialize_message(cut.origin, TaskMsg))
        kept = shown_again_from(task, cut.again) if cut.again >= 0 else None
        recording = cut.into(Recording(task.source, cut.begin, kept, wanted))
        return KeptRecording(recording, task, cut.again, cut.cuts)
    except (RuntimeError, ValueError, IndexError, OverflowError, MbdError) as error:  # the first: of rclpy's C layer
        raise MbdError(f"{path} holds a recording that cannot be gone on with: {error}") from error


def kept_path(running: Path, task: Task) -> ToolTrajectory | None:
    """Where the tool went as a task was recorded; None where that was not kept, or of another task.

    Args:
        running: file of a recording that runs, beside which the complete one is.
        task: as recorded and corrected.

    Raises:
        MbdError: the file holds what cannot be read.
    """
    whole = kept_recording(completed(running), ())
    if whole is None or not task.steps:
        return None
    recording, origin = whole.recording, whole.task
    path = recording.trajectory()[0]
    last = task.steps[-1].end
    covers = len(path.stamps) > 0 and float(path.stamps[0]) <= last <= float(path.stamps[-1])
    return path if covers and origin.source.stamp == task.source.stamp else None
