"""The teacher really does the task: objects move with the hand and end where they belong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.arm.kinematics import DownwardToolPose, UnreachableError
from mbd_cell.cell import Cell
from mbd_cell.physics.camera import Camera
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.teacher.script import Word
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.task import StepKind
from shipped_scenes import TASKS, demonstrated, play, scenes_of

pytestmark = pytest.mark.system


def upright(cell: Cell, name: str) -> float:
    """Cosine of the object's tilt."""
    x, y, _, _ = cell.simulation.object_pose(name).quaternion
    return 1 - 2 * (x * x + y * y)


def aside(cell: Cell, name: str, other: str) -> float:
    """Horizontal distance of two objects' centres [m]."""
    return math.dist(cell.simulation.object_pose(name).position[:2], cell.simulation.object_pose(other).position[:2])


def test_the_stacked_cups_stand_on_one_another() -> None:
    cell, _ = demonstrated("stacking")
    tower = [cell.scenes.steps[0].picked, *(s.picked for s in cell.scenes.steps[2::2])]
    below = cell.scenes.steps[1].onto
    for name in tower:
        assert below is not None
        lower, upper = cell.simulation.objects[below], cell.simulation.objects[name]
        top = cell.simulation.object_pose(below).position[2] + lower.size[2] / 2
        bottom = cell.simulation.object_pose(name).position[2] - upper.size[2] / 2
        assert bottom == pytest.approx(top, abs=0.003), f"{name} on {below}"
        assert aside(cell, name, below) < 0.008
        assert upright(cell, name) > 0.999
        below = name


def test_the_sorted_cups_stand_inside_the_large_ones_of_their_colour() -> None:
    cell, _ = demonstrated("sorting")
    for colour in ("red", "green", "blue"):
        inner, outer = f"small_{colour}", f"large_{colour}"
        assert aside(cell, inner, outer) < 0.012
        bottom = cell.simulation.object_pose(inner).position[2] - cell.simulation.objects[inner].size[2] / 2
        assert 0.0 < bottom < 0.01


def test_the_lunch_is_in_the_box() -> None:
    cell, _ = demonstrated("lunch_packing")
    half = [v / 2 for v in cell.simulation.objects["lunch_box"].size]
    for name in ("milk", "chips", "pear"):
        assert aside(cell, name, "lunch_box") < math.hypot(half[0], half[1])
        assert cell.simulation.object_pose(name).position[2] > half[2]


@pytest.mark.parametrize("task", TASKS)
def test_the_teacher_states_one_word_a_step_and_holds_what_the_step_names(task: str) -> None:
    cell, received = demonstrated(task)
    words = [word for word, _, _ in received]
    per_step = [Word.CLOSE if s.kind is StepKind.PICK else Word.OPEN for s in cell.scenes.steps]
    assert words == [Word.DEMONSTRATION_BEGINS, *per_step, Word.DEMONSTRATION_ENDS]
    for step, (_, _, held) in zip(cell.scenes.steps, received[1:-1], strict=True):
        assert held == (None if step.kind is StepKind.PICK else step.picked)


def test_a_grasped_object_moves_with_the_hand_and_stays_where_it_was_in_it() -> None:
    cell = Cell(scenes_of("assembly"), 5, CELL_CAMERA)
    offsets = []

    cell.demonstrate()
    while cell.waiting_for is not Word.OPEN:
        cell.tick()
        for word in cell.take_spoken():
            if word is Word.DEMONSTRATION_BEGINS:
                cell.begin()
            elif word is Word.CLOSE:
                cell.gripper(GripperCommand.CLOSE)
        if cell.holding:
            tool, held = cell.simulation.tool.position, cell.simulation.object_pose(cell.holding).position
            offsets.append(math.dist(tool, held))
    assert len(offsets) > 200
    assert max(offsets[20:]) - min(offsets[20:]) < 0.004


def test_an_object_let_go_falls_and_comes_to_rest() -> None:
    cell = Cell(scenes_of("assembly"), 5, CELL_CAMERA)
    play(cell, until=lambda cell, word: word is Word.OPEN)
    name = cell.holding
    assert name is not None
    cell.stop()
    cell.move_tool(cell.arm.pose.moved(dz=0.06), 0.1)
    while cell.busy:
        cell.tick()
    lifted = cell.simulation.object_pose(name).position[2]
    cell.gripper(GripperCommand.OPEN)
    for _ in range(150):
        cell.tick()
    rest = cell.simulation.object_pose(name).position[2]
    assert cell.holding is None
    assert lifted > 0.07
    assert rest == pytest.approx(cell.simulation.objects[name].size[2] / 2, abs=0.002)


def test_a_hand_that_closes_on_air_holds_nothing() -> None:
    cell = Cell(scenes_of("sorting"), 1, CELL_CAMERA)
    cell.move_gripper(GripperCommand.CLOSE)
    while cell.busy:
        cell.tick()
    assert cell.holding is None
    assert cell.opening == 0.0


def test_the_clock_stands_still_until_the_wizard_gives_the_word_the_teacher_waits_for() -> None:
    cell = Cell(scenes_of("sorting"), 1, CELL_CAMERA)
    cell.demonstrate()
    cell.tick()
    assert cell.waiting_for is Word.DEMONSTRATION_BEGINS
    before = (cell.time_ns, cell.simulation.data.qpos.copy())
    assert not cell.gripper(GripperCommand.CLOSE)
    for _ in range(50):
        assert not cell.tick()
    assert cell.time_ns == before[0]
    assert np.array_equal(cell.simulation.data.qpos, before[1])
    assert cell.begin()
    assert cell.tick()


def test_the_same_seed_and_commands_give_bit_equal_states_and_images() -> None:
    outcomes = []
    for _ in range(2):
        cell = Cell(scenes_of("sorting"), 11, CELL_CAMERA)
        play(cell, until=lambda cell, word: word is Word.OPEN)
        with Camera(cell.model) as camera:
            frame = camera.render(cell.simulation, cell.image_rng())
        state = np.concatenate((cell.simulation.data.qpos, cell.simulation.data.qvel))
        outcomes.append((cell.time_ns, state.tobytes(), frame.color.tobytes(), frame.depth.tobytes()))
    assert outcomes[0] == outcomes[1]


def test_another_seed_guides_another_path() -> None:
    ends = []
    for seed in (1, 2):
        cell = Cell(scenes_of("sorting"), seed, CELL_CAMERA)
        play(cell, until=lambda cell, word: word is Word.CLOSE)
        ends.append(cell.simulation.tool.position)
    assert ends[0] != ends[1]


def test_laying_the_other_set_keeps_arm_and_clock() -> None:
    cell = Cell(scenes_of("sorting"), 1, CELL_CAMERA)
    for _ in range(10):
        cell.tick()
    before = (cell.time_ns, cell.simulation.arm_joints)
    cell.lay(Role.TARGET, 1)
    assert cell.time_ns == before[0]
    assert np.allclose(cell.simulation.arm_joints, before[1], atol=1e-3)
    assert set(cell.simulation.objects) == {o.name for o in cell.scenes.target}


def test_a_goal_out_of_reach_leaves_the_arm_where_it_is() -> None:
    cell = Cell(scenes_of("sorting"), 1, CELL_CAMERA)
    before = cell.arm.target.copy()
    with pytest.raises(UnreachableError):
        cell.move_tool(DownwardToolPose(2.0, 0.0, 0.2, 0.0), 0.2)
    assert not cell.busy
    assert np.array_equal(cell.arm.target, before)


def test_an_object_that_is_not_there_is_asked_for_in_vain() -> None:
    cell, _ = demonstrated("sorting")
    with pytest.raises(MbdError, match="small_red"):
        cell.simulation.object_pose("teapot")


def test_the_picture_shows_the_tucked_arm_away_from_the_objects() -> None:
    cell = Cell(scenes_of("sorting"), 1, CELL_CAMERA)
    with Camera(cell.model) as camera:
        frame = camera.render(cell.simulation, None)
    # What is higher than the tallest cup is the arm; it must lie at the lower edge, behind the table's near edge.
    rows = np.nonzero((frame.depth > 0) & (frame.depth < 0.85))[0]
    assert rows.size == 0 or rows.min() > 420
