"""What friction does: things held, lost, pushed, tipped, rolled and nested, with nothing fixed to the hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.arm.grasp_planning import grasp_pose
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_cell.cell import Cell
from mbd_cell.layout.placement import Placement
from mbd_cell.layout.scenes import ObjectSpec, Shape, TaskScenes
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.cell_model import build_model
from mbd_cell.physics.grasp import Grasp
from mbd_cell.physics.robots import JACO, cell_robot
from mbd_cell.physics.simulation import Simulation
from mbd_execution.hand import HandConfig
from shipped_scenes import scenes_of

AWAY = Placement("", 0.45, 0.0, 0.0)
CUP = ObjectSpec("cup", Shape.CUP, (0.052, 0.052, 0.065), 0.0, 0.056)
MUG = ObjectSpec("mug", Shape.CUP, (0.075, 0.075, 0.094), 30.0, 0.068)
LID = ObjectSpec("lid", Shape.CUP, (0.08, 0.08, 0.02), 60.0, 0.03, upside_down=True)
BOWL = ObjectSpec("bowl", Shape.BOWL, (0.12, 0.12, 0.05), 40.0, 0.2)
BOX = ObjectSpec("box", Shape.BOX, (0.095, 0.045, 0.09), 15.0, 0.06)
FORK = ObjectSpec("fork", Shape.UTENSIL, (0.15, 0.019, 0.016), 40.0, 0.04)
PEAR = ObjectSpec("pear", Shape.ELLIPSOID, (0.062, 0.058, 0.05), 75.0, 0.1)
BALL = ObjectSpec("ball", Shape.ELLIPSOID, (0.05, 0.05, 0.05), 75.0, 0.1)


def a_cell(thing: ObjectSpec, hand: str = "jaco") -> Cell:
    """One object alone in reach."""
    alone = replace(thing, region=(0.42, 0.46, -0.02, 0.02))
    scenes = TaskScenes("alone", (alone,), (alone,), (), {})
    return Cell(scenes, 1, CELL_CAMERA, cell_robot("jaco", hand), Grasp.FRICTION)


def on_the_table(*things: ObjectSpec) -> Simulation:
    """The objects side by side under a folded arm."""
    places = [replace(AWAY, name=t.name, y=0.2 * (i - len(things) // 2)) for i, t in enumerate(things)]
    model = build_model(things, places, CELL_CAMERA, 45.0, grasp=Grasp.FRICTION)
    return Simulation(model, things, np.array(JACO.arm.tucked), np.full(3, JACO.hand.open_angle))


def put(simulation: Simulation, name: str, position: tuple[float, float, float], lean: float = 0.0) -> None:
    """Set the object there, leaning about x by that [rad], at rest."""
    joint = simulation.data.joint(name)
    joint.qpos[:] = (*position, math.cos(lean / 2), math.sin(lean / 2), 0.0, 0.0)
    joint.qvel[:] = 0.0


def let_pass(simulation: Simulation, seconds: float) -> None:
    """Nothing else moves."""
    arm, fingers = simulation.arm_joints, simulation.finger_joints
    for _ in range(round(seconds * 100)):
        simulation.tick(arm, fingers)


def place_of(simulation: Simulation, name: str) -> np.ndarray:
    """Position [m]."""
    return np.array(simulation.object_pose(name).position)


def lean_of(simulation: Simulation, name: str) -> float:
    """Angle of its axis to the vertical [rad]."""
    x, y, _, _ = simulation.object_pose(name).quaternion
    return math.acos(max(-1.0, min(1.0, 1 - 2 * (x * x + y * y))))


def until_still(cell: Cell, limit: int = 1500) -> None:
    for _ in range(limit):
        cell.tick()
        if not cell.busy:
            return
    pytest.fail("the cell did not come to rest")


def close_around(cell: Cell, name: str, off: float = 0.0) -> DownwardToolPose:
    """Go to the object, the tool that far [m] beside its middle, and close the hand."""
    goal = grasp_pose(cell.simulation.objects[name], cell.simulation.object_pose(name), near_yaw=0.0).moved(dy=off)
    for end in (goal.moved(dz=0.12), goal):
        cell.move_tool(end, 0.5)
        until_still(cell)
    cell.gripper(GripperCommand.CLOSE)
    until_still(cell)
    return goal


def in_hand(cell: Cell, name: str) -> np.ndarray:
    """Where the object is from the tool [m]."""
    return place_of(cell.simulation, name) - np.array(cell.simulation.tool.position)


@pytest.mark.parametrize(
    ("hand", "thing", "seconds"), [("jaco", BOX, 30), ("2f85", BOX, 30), ("jaco", CUP, 3), ("2f85", PEAR, 3)]
)
def test_what_a_hand_presses_it_lifts_and_keeps_to_the_millimetre(hand: str, thing: ObjectSpec, seconds: int) -> None:
    cell = a_cell(thing, hand)
    start = place_of(cell.simulation, thing.name)
    goal = close_around(cell, thing.name)
    assert cell.fingers_stopped
    assert cell.holding == thing.name
    cell.move_tool(goal.moved(dz=0.1), 0.3)
    until_still(cell)
    lifted = in_hand(cell, thing.name)
    for _ in range(100 * seconds):
        cell.tick()
    assert np.linalg.norm(in_hand(cell, thing.name) - lifted) < 0.001
    assert place_of(cell.simulation, thing.name)[2] - start[2] == pytest.approx(0.1, abs=0.004)
    cell.gripper(GripperCommand.OPEN)
    until_still(cell)
    assert cell.holding is None
    for _ in range(50):
        cell.tick()
    assert place_of(cell.simulation, thing.name)[2] < 0.06


@pytest.mark.parametrize("rim", [0.108, 0.132])
def test_a_bowl_hangs_level_from_its_rim_in_a_hand_that_leans_along_its_wall(rim: float) -> None:
    hand = HandConfig()
    leans = {}
    for tilt in (hand.rim_tilt, 0.0):
        cell = a_cell(replace(BOWL, size=(rim, rim, 0.42 * rim)))
        x, y, z = place_of(cell.simulation, "bowl")
        goal = DownwardToolPose(x, y + rim / 2 - hand.rim_in, z + 0.21 * rim - hand.rim_depth, 0.0, tilt)
        for end in (goal.moved(dz=0.1), goal):
            cell.move_tool(end, 0.4)
            until_still(cell)
        cell.gripper(GripperCommand.CLOSE)
        until_still(cell)
        cell.move_tool(goal.moved(dz=0.1), 0.2)
        until_still(cell)
        leans[tilt] = lean_of(cell.simulation, "bowl") if cell.holding else math.inf
    assert leans[hand.rim_tilt] < 0.1 < leans[0.0]


@pytest.mark.parametrize("side", [0.046, 0.061, 0.071])
def test_a_hand_that_opens_leaves_what_it_held_where_it_was(side: float) -> None:
    """All fingers leave at once: one that presses longer than the others would push what they have left."""
    cell = a_cell(replace(CUP, size=(side, side, 1.3 * side)))
    goal = close_around(cell, "cup")
    cell.move_tool(goal.moved(dz=0.006), 0.2)
    until_still(cell)
    held = place_of(cell.simulation, "cup")
    cell.gripper(GripperCommand.OPEN)
    until_still(cell)
    assert np.linalg.norm((place_of(cell.simulation, "cup") - held)[:2]) < 0.002


@settings(max_examples=2, deadline=None)
@given(st.floats(8.0, 12.0))
def test_what_is_too_heavy_for_the_grip_slips_out_of_it(mass: float) -> None:
    cell = a_cell(replace(BOX, mass=mass))
    goal = close_around(cell, "box")
    cell.move_tool(goal.moved(dz=0.1), 0.3)
    until_still(cell)
    assert cell.holding is None
    assert place_of(cell.simulation, "box")[2] < 0.06


@pytest.mark.parametrize("hand", ["jaco", "2f85"])
def test_a_hand_that_closes_beside_an_object_holds_nothing_and_can_tell(hand: str) -> None:
    cell = a_cell(CUP, hand)
    close_around(cell, "cup", off=0.15)
    assert cell.holding is None
    assert not cell.fingers_stopped
    assert cell.opening < 0.04


def test_an_object_taken_away_from_between_the_fingers_is_held_no_more_and_they_close() -> None:
    cell = a_cell(CUP)
    close_around(cell, "cup")
    put(cell.simulation, "cup", (0.45, 0.3, 0.0325))
    for _ in range(250):
        cell.tick()
    assert cell.holding is None
    assert not cell.fingers_stopped


def test_a_closed_hand_pushes_what_stands_in_its_way() -> None:
    cell = a_cell(BOX)
    start = place_of(cell.simulation, "box")
    cell.move_gripper(GripperCommand.CLOSE)
    until_still(cell)
    before = DownwardToolPose(start[0], start[1] - 0.12, 0.03, 0.0)
    for goal in (before.moved(dz=0.17), before):
        cell.move_tool(goal, 0.4)
        until_still(cell)
    cell.move_tool(before.moved(dy=0.14), 0.1)
    until_still(cell)
    moved = place_of(cell.simulation, "box") - start
    assert moved[1] > 0.03
    assert cell.holding is None


@settings(max_examples=4, deadline=None)
@given(st.floats(0.2, 0.5))
def test_a_cup_tilted_a_little_stands_up_again_and_one_tilted_too_far_falls(share: float) -> None:
    # It tips where its middle passes the edge of its floor.
    edge = math.atan2(0.92 * 0.95 * CUP.size[0] / 2, CUP.size[2] / 2)
    for lean, falls in ((share * edge, False), ((1.5 + share) * edge, True)):
        simulation = on_the_table(CUP)
        x, y, _ = place_of(simulation, "cup")
        lowest = CUP.size[2] / 2 * math.cos(lean) + CUP.size[0] / 2 * math.sin(lean)
        put(simulation, "cup", (x, y, lowest), lean)
        let_pass(simulation, 1.5)
        assert (lean_of(simulation, "cup") > 1.2) is falls
        assert falls or lean_of(simulation, "cup") < 0.02


@pytest.mark.parametrize(("thing", "lean"), [(BALL, 0.0), (CUP, math.pi / 2)])
def test_what_is_round_rolls_and_what_is_not_slides_to_rest(thing: ObjectSpec, lean: float) -> None:
    ways = []
    for pushed, tilt in ((thing, lean), (replace(BOX, name=thing.name, size=(0.05, 0.05, 0.05)), 0.0)):
        simulation = on_the_table(pushed)
        put(simulation, thing.name, (0.45, 0.0, pushed.size[1] / 2 if tilt else pushed.size[2] / 2), tilt)
        simulation.data.joint(thing.name).qvel[0] = 0.4
        let_pass(simulation, 0.5)
        ways.append(place_of(simulation, thing.name)[0] - 0.45)
    assert ways[0] > 0.05
    assert ways[1] < 0.02


def test_cups_nest_and_a_lid_laid_half_over_a_rim_falls() -> None:
    simulation = on_the_table(CUP, MUG, LID)
    x, y, _ = place_of(simulation, "mug")
    put(simulation, "cup", (x, y, 0.1))
    let_pass(simulation, 1.0)
    inside = place_of(simulation, "cup")
    assert inside[2] - CUP.size[2] / 2 == pytest.approx(0.003, abs=0.002)
    assert math.dist(inside[:2], (x, y)) < 0.01
    put(simulation, "lid", (x + 0.055, y, MUG.size[2] + 0.02))
    let_pass(simulation, 1.0)
    assert place_of(simulation, "lid")[2] < 0.06
    assert place_of(simulation, "mug")[2] == pytest.approx(MUG.size[2] / 2, abs=0.001)


def test_what_stands_stays_where_it_stands() -> None:
    simulation = on_the_table(CUP, LID, BOX, FORK, PEAR)
    let_pass(simulation, 1.0)
    before = {name: place_of(simulation, name) for name in simulation.objects}
    let_pass(simulation, 8.0)
    for name, place in before.items():
        assert np.linalg.norm(place_of(simulation, name) - place) < 1e-4, name


@pytest.mark.system
def test_the_teacher_does_a_task_by_friction_alone_and_twice_the_same() -> None:
    ends = []
    for _ in range(2):
        cell = Cell(scenes_of("lunch_packing"), 2, CELL_CAMERA, grasp=Grasp.FRICTION)
        cell.demonstrate()
        held = set()
        while cell.busy and len(held) < 1:
            cell.tick()
            if cell.waiting_for is not None and not cell.begin():
                cell.gripper(GripperCommand.CLOSE)
            held |= {cell.holding} - {None}
        for _ in range(200):
            cell.tick()
        assert held == {"milk"}
        assert cell.holding == "milk"
        ends.append(np.concatenate((cell.simulation.data.qpos, cell.simulation.data.qvel)).tobytes())
    assert ends[0] == ends[1]
