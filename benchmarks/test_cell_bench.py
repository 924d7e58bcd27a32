"""The simulated cell's pace: a complete demonstration against its own clock, and one noisy RGB-D frame."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from mbd_cell.cell import Cell
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.physics.camera import Camera
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robots import JACO
from mbd_cell.teacher.script import ANSWERED_BY_GRIPPER, Word

CONFIG = Path(__file__).resolve().parents[1] / "ros2_ws" / "src" / "mbd_cell" / "config"


def a_cell(task: str, grasp: Grasp = Grasp.WELD) -> Cell:
    """The source set of that task on the table."""
    return Cell(load_scenes(CONFIG / f"{task}.yaml"), 1, CELL_CAMERA, JACO, grasp)


def demonstrate(cell: Cell) -> float:
    """Let the teacher show the complete task to a wizard who answers at once; returns the time it took there [s]."""
    begun = cell.time_ns
    cell.demonstrate()
    while cell.busy:
        cell.tick()
        for word in cell.take_spoken():
            if word is Word.DEMONSTRATION_BEGINS:
                cell.begin()
            elif word in ANSWERED_BY_GRIPPER:
                cell.gripper(ANSWERED_BY_GRIPPER[word])
    return (cell.time_ns - begun) / 1e9


@pytest.mark.parametrize("grasp", list(Grasp))
@pytest.mark.parametrize("task", ["lunch_packing", "sorting"])
def test_a_demonstration_faster_than_real_time(benchmark, task, grasp):
    paces = []

    def play(cell: Cell) -> None:
        begun = time.perf_counter()
        passed = demonstrate(cell)
        paces.append(passed / (time.perf_counter() - begun))

    benchmark.pedantic(play, setup=lambda: ((a_cell(task, grasp),), {}), rounds=2)
    benchmark.extra_info["times real time"] = round(float(np.mean(paces)), 1)
    print(f"\n{task}, grasps by {grasp}: {np.mean(paces):.1f} times real time")


def test_a_noisy_frame(benchmark):
    cell = a_cell("sorting")
    with Camera(cell.model) as camera:
        benchmark.pedantic(lambda: camera.render(cell.simulation, cell.image_rng()), rounds=10, warmup_rounds=1)


@pytest.mark.timeout(3600)
def test_an_hour_at_rest(benchmark):
    """Every shape of two tasks stands for an hour of the cell's time; prints how far it wandered."""
    wandered = {}

    def stand() -> None:
        for task in ("lunch_packing", "dish_sorting"):
            simulation = a_cell(task, Grasp.FRICTION).simulation
            arm, fingers = simulation.arm_joints, simulation.finger_joints
            for tick in range(361_000):
                if tick == 1000:
                    began = {name: np.array(simulation.object_pose(name).position) for name in simulation.objects}
                simulation.tick(arm, fingers)
            for name, place in began.items():
                wandered[name] = float(np.linalg.norm(np.array(simulation.object_pose(name).position) - place))

    benchmark.pedantic(stand, rounds=1)
    print(f"\nafter an hour at rest, farthest off: {1000 * max(wandered.values()):.4f} mm")
    assert max(wandered.values()) < 0.001, wandered
