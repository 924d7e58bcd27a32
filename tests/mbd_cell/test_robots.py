"""Other arms and hands in the cell: they reach the table with the hand down, and hold what they close around."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mbd_cell.arm.grasp_planning import grasp_pose
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.cell import Cell, points_down
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.physics.arms import ARMS
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.hands import HANDS
from mbd_cell.physics.robots import cell_robot
from mbd_model.errors import MbdError

SCENES = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"
ROBOTS = [("jaco", "jaco"), ("jaco", "2f85"), ("gen3", "2f85"), ("ur5e", "2f85"), ("fr3", "franka")]


def until_still(cell: Cell, limit: int = 1500) -> None:
    for _ in range(limit):
        cell.tick()
        if not cell.busy:
            return
    pytest.fail("the cell did not come to rest")


@pytest.mark.parametrize(("arm", "hand"), ROBOTS)
def test_it_goes_to_a_cup_holds_it_lifts_it_and_lets_it_go(arm: str, hand: str):
    cell = Cell(load_scenes(SCENES / "sorting.yaml"), 1, CELL_CAMERA, cell_robot(arm, hand))
    thing, start = cell.simulation.objects["small_red"], cell.simulation.object_pose("small_red")
    grasp = grasp_pose(thing, start, near_yaw=0.0)
    for goal in (grasp.moved(dz=0.12), grasp):
        cell.move_tool(goal, 0.4)
        until_still(cell)
    assert points_down(cell.simulation.tool)
    assert cell.simulation.tool.position == pytest.approx(grasp.position, abs=0.005)
    cell.gripper(GripperCommand.CLOSE)
    until_still(cell)
    assert cell.holding == "small_red"
    assert 0.05 < cell.opening < 0.95
    cell.move_tool(grasp.moved(dz=0.1), 0.4)
    until_still(cell)
    assert cell.simulation.object_pose("small_red").position[2] > start.position[2] + 0.08
    cell.gripper(GripperCommand.OPEN)
    until_still(cell)
    assert cell.holding is None
    assert cell.opening == pytest.approx(1.0)


@pytest.mark.parametrize(("arm", "hand"), ROBOTS)
def test_a_hand_that_closes_on_nothing_holds_nothing_and_closes_to_its_end(arm: str, hand: str):
    cell = Cell(load_scenes(SCENES / "sorting.yaml"), 1, CELL_CAMERA, cell_robot(arm, hand))
    cell.gripper(GripperCommand.CLOSE)
    until_still(cell)
    assert cell.holding is None
    model = cell.robot.hand
    way = model.closed_angle - model.open_angle
    assert cell.simulation.finger_joints == pytest.approx(np.full(len(model.joints), model.closed_angle), abs=0.1 * way)


def test_a_trajectory_is_followed_tick_by_tick():
    cell = Cell(load_scenes(SCENES / "sorting.yaml"), 1, CELL_CAMERA, cell_robot("ur5e", "2f85"))
    start = cell.arm.target.copy()
    way = [start + 0.002 * k * np.eye(6)[0] for k in range(1, 101)]
    cell.follow(iter(way))
    assert cell.following
    until_still(cell)
    assert cell.simulation.arm_joints == pytest.approx(way[-1], abs=0.03)


def test_an_arm_or_hand_that_is_not_there_is_refused_with_those_there_are():
    with pytest.raises(MbdError, match="no arm 'ur10'; there are: jaco, gen3"):
        cell_robot("ur10", "2f85")
    with pytest.raises(MbdError, match="no hand 'pinza'"):
        cell_robot("ur5e", "pinza")
    assert {arm for arm, _ in ROBOTS} == set(ARMS)
    assert {hand for _, hand in ROBOTS} == set(HANDS)
