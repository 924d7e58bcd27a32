"""The shipped scene files, and demonstrations played through once for all tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from mbd_cell.cell import Cell
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.layout.scenes import TaskScenes
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"
TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


@cache
def scenes_of(task: str) -> TaskScenes:
    """The shipped scenes of that task."""
    return load_scenes(CONFIG / f"{task}.yaml")


def play(cell: Cell, until: Callable[[Cell, Word], bool] | None = None) -> list[tuple[Word, int, str | None]]:
    """Let the teacher show the task with a wizard who answers at once; returns (word, time, object held then)."""
    received: list[tuple[Word, int, str | None]] = []
    cell.demonstrate()
    while cell.busy:
        cell.tick()
        for word in cell.take_spoken():
            received.append((word, cell.time_ns, cell.holding))
            if until is not None and until(cell, word):
                return received
            if word is Word.DEMONSTRATION_BEGINS:
                cell.begin()
            elif word in ANSWERED_BY_GRIPPER:
                cell.gripper(ANSWERED_BY_GRIPPER[word])
    return received


@cache
def demonstrated(task: str) -> tuple[Cell, list[tuple[Word, int, str | None]]]:
    """A cell after the complete demonstration, and what was spoken; shared, so only to be looked at."""
    cell = Cell(scenes_of(task), 3, CELL_CAMERA)
    return cell, play(cell)
