"""The tasks that the simulated cell can lay: one there is not is refused before anything starts."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from mbd_cell.layout.scene_file import NO_SCENES
from mbd_model.errors import MbdError
from mbd_model.parameters import nearest

from mbd_bringup.nodes import SessionOptions


def refuse_unknown_task(options: SessionOptions) -> None:
    """Refuse a simulated session of a task that the cell has no scenes of; with a real robot a task is any name.

    Raises:
        MbdError: it has none; names the nearest, and those there are.
    """
    files = (Path(get_package_share_directory("mbd_cell")) / "config").glob("*.yaml")
    tasks = sorted(file.stem for file in files if file.stem not in NO_SCENES)
    if options.simulated and options.task not in tasks:
        near = nearest(options.task, tasks)
        advice = f"did you mean '{near}'? " if near else ""
        raise MbdError(f"the simulated cell has no task '{options.task}'; {advice}there are {', '.join(tasks)}")
