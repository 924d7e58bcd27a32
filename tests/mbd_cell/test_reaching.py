"""The arm reaches the table, and guided paths are smooth and end where they should."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.arm.kinematics import HOME, ArmKinematics, DownwardToolPose, UnreachableError
from mbd_cell.arm.motion import angle_between, guided_path
from mbd_cell.layout.placement import MAX_REACH, REGION
from mbd_cell.physics.camera import FOVY
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.cell_model import build_model

places = st.tuples(
    st.floats(REGION[0], REGION[1]), st.floats(REGION[2], REGION[3]), st.floats(0.01, 0.25), st.floats(-1.5, 1.5)
).filter(lambda p: p[0] ** 2 + p[1] ** 2 <= MAX_REACH**2)


@cache
def kinematics() -> ArmKinematics:
    return ArmKinematics(build_model([], [], CELL_CAMERA, FOVY))


@settings(max_examples=25)
@given(places)
def test_a_guided_path_reaches_every_place_objects_can_stand_at(place: tuple[float, float, float, float]) -> None:
    arm = kinematics()
    joints = np.array(HOME)
    goal = DownwardToolPose(*place)
    path = list(guided_path(arm.tool_pose(joints), goal, 0.5, 0.0, np.random.default_rng(0)))
    for pose in [*path[::10], path[-1]]:
        joints = arm.solve(pose, joints)
    reached = arm.tool_pose(joints)
    assert np.allclose(reached.position, goal.position, atol=1e-3)
    assert abs(angle_between(reached.yaw, goal.yaw)) < 1e-2


def test_a_place_beyond_reach_is_refused_with_the_place() -> None:
    with pytest.raises(UnreachableError, match=r"1\.200"):
        kinematics().solve(DownwardToolPose(1.2, 0.0, 0.1, 0.0), np.array(HOME))


@given(st.integers(0, 1000), st.floats(0.0, 0.01))
def test_a_guided_path_ends_exactly_at_its_goal_and_never_jumps(seed: int, tremble: float) -> None:
    start, goal = DownwardToolPose(0.3, -0.2, 0.2, 0.3), DownwardToolPose(0.5, 0.3, 0.1, -0.4)
    path = list(guided_path(start, goal, 0.25, tremble, np.random.default_rng(seed)))
    positions = np.array([start.position, *(p.position for p in path)])
    assert np.array_equal(positions[-1], goal.position)
    assert np.linalg.norm(np.diff(positions, axis=0), axis=1).max() < 0.01 * (2 * 0.25 + 20 * tremble)


def test_a_path_without_tremble_is_straight() -> None:
    start, goal = DownwardToolPose(0.3, -0.2, 0.2, 0.0), DownwardToolPose(0.5, 0.3, 0.1, 0.0)
    along = (goal.position - start.position) / np.linalg.norm(goal.position - start.position)
    for pose in guided_path(start, goal, 0.25, 0.0, np.random.default_rng(1)):
        off = pose.position - start.position
        assert np.linalg.norm(off - (off @ along) * along) < 1e-12


def test_the_hand_turns_the_shorter_way_round() -> None:
    path = list(
        guided_path(
            DownwardToolPose(0.4, 0, 0.2, 3.0), DownwardToolPose(0.4, 0, 0.2, -3.0), 0.2, 0.0, np.random.default_rng(1)
        )
    )
    assert all(3.0 <= p.yaw <= 2 * np.pi - 3.0 + 1e-9 for p in path)
