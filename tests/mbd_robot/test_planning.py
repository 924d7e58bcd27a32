from __future__ import annotations

import itertools
import math
from functools import cache

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mbd_cell.physics.camera import FOVY
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.cell_model import build_model
from mbd_cell.physics.robots import cell_robot
from mbd_execution.goals import ToolGoal
from mbd_execution.hand import HandConfig
from mbd_model.parameters import ParameterError
from mbd_robot.geometry import HeldBoxes, Obstacle, RobotToolPose, hand_zone_box
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.kinematics.descriptions import MODELS, ModelError, load_description
from mbd_robot.kinematics.inverse import OutOfReachError
from mbd_robot.motion.joint_search import between, connect
from mbd_robot.motion.planning import BlockedError, MotionPlanner
from mbd_robot.motion.timing import JointLimits, along, joined, swing
from mbd_robot.profiles.find import robot_names, robot_profile

PLANNED = tuple(n for n in robot_names() if robot_profile(n).arm.interface.value == "follow_joint_trajectory")


@cache
def chain(name: str) -> ArmChain:
    return ArmChain(robot_profile(name))


@cache
def planner(name: str) -> MotionPlanner:
    return MotionPlanner(chain(name))


def down(x: float, y: float, z: float, yaw: float) -> RobotToolPose:
    return RobotToolPose(np.array((x, y, z)), np.array((math.cos(yaw / 2), math.sin(yaw / 2), 0.0, 0.0)))


places = st.builds(
    down, st.floats(0.3, 0.5), st.floats(-0.25, 0.25), st.floats(0.03, 0.3), st.floats(-1.2, 1.2)
)  # fmt: skip


@pytest.mark.parametrize("name", robot_names())
def test_the_chain_is_where_the_simulated_robot_is(name: str):
    """For the Jaco two models of two makers: Kinova's description here, dm-control's in the cell."""
    profile = robot_profile(name)
    assert profile.stand_in is not None
    robot = cell_robot(profile.stand_in.arm, profile.stand_in.hand)
    model = build_model([], [], CELL_CAMERA, FOVY, robot)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    site = model.site(robot.tool_site).id
    for _ in range(5):
        joints = np.array(profile.arm.ready) + rng.uniform(-0.5, 0.5, len(profile.arm.ready))
        data.qpos[[model.joint(n).qposadr[0] for n in robot.arm_joints]] = joints
        mujoco.mj_kinematics(model, data)
        pose = chain(name).tool_pose(joints)
        assert pose.position == pytest.approx(data.site_xpos[site], abs=2e-4)
        assert pose.rotation.as_matrix() == pytest.approx(data.site_xmat[site].reshape(3, 3), abs=2e-3)


@pytest.mark.parametrize("name", PLANNED)
@settings(max_examples=6, suppress_health_check=[HealthCheck.too_slow])
@given(start=places, goal=places)
def test_a_plan_ends_at_its_goal_straight_within_limits_and_at_rest(
    name: str, start: RobotToolPose, goal: RobotToolPose
):  # fmt: skip
    arm = robot_profile(name).arm
    first = planner(name).plan(np.array(arm.ready), start, 0.25)
    timed = planner(name).plan(first.positions[-1], goal, 0.25)
    assert timed.positions[0] == pytest.approx(first.positions[-1])
    assert chain(name).tool_pose(timed.positions[-1]).position == pytest.approx(goal.position, abs=1e-3)
    assert (np.diff(timed.times) > 0).all()
    assert (np.abs(timed.velocities) <= np.array(arm.max_velocity) * 1.05).all()
    assert np.abs(timed.velocities[[0, -1]]).max() == 0.0
    assert all((timed.positions >= chain(name).low - 1e-9).all(1) & (timed.positions <= chain(name).high + 1e-9).all(1))
    line = goal.position - start.position
    for joints in timed.positions[:: max(1, len(timed.positions) // 8)]:
        off = chain(name).tool_pose(joints).position - start.position
        across = off - line * (off @ line) / max(float(line @ line), 1e-9)
        assert np.linalg.norm(across) < 0.01 or np.linalg.norm(line) < 0.01


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_reaches_where_it_goes_to_look_also_with_a_hand_that_leans(name: str):
    x, y, z, yaw = robot_profile(name).arm.look_from
    for tilt in (0.0, HandConfig().rim_tilt):
        goal = ToolGoal(x, y, z, yaw, tilt)
        pose = RobotToolPose(np.array((x, y, z)), np.array(goal.quaternion))
        timed = planner(name).plan(np.array(robot_profile(name).arm.ready), pose, 0.25)
        assert chain(name).tool_pose(timed.positions[-1]).position == pytest.approx((x, y, z), abs=1e-3)


@pytest.mark.parametrize("name", PLANNED)
def test_a_goal_out_of_reach_is_said_to_be(name: str):
    with pytest.raises(OutOfReachError, match="does not reach"):
        planner(name).plan(np.array(robot_profile(name).arm.ready), down(1.6, 0.0, 0.2, 0.0), 0.25)


@pytest.mark.parametrize("name", PLANNED)
def test_a_folded_arm_does_not_pass_over_its_own_base(name: str):
    profile = robot_profile(name)
    assert profile.stand_in is not None
    tucked = np.array(cell_robot(profile.stand_in.arm, profile.stand_in.hand).arm.tucked)
    behind = chain(name).tool_pose(tucked).position
    timed = planner(name).plan(tucked, down(0.4, -0.2, 0.25, 0.0), 0.25)
    way = np.array([chain(name).tool_pose(q).position for q in timed.positions])
    assert np.linalg.norm(way[:, :2], axis=1).min() > min(0.18, float(np.linalg.norm(behind[:2])) - 0.02)


def test_a_way_through_an_object_is_blocked_and_named():
    own = ArmChain(robot_profile("ur5e"))
    ready = np.array(robot_profile("ur5e").arm.ready)
    own.surround([Obstacle("tower", (0.45, -0.2, 0.3), (0.06, 0.06, 0.6))])
    with pytest.raises(BlockedError, match="tower") as blocked:
        MotionPlanner(own).plan(ready, down(0.45, -0.25, 0.1, 0.0), 0.25)
    assert blocked.value.thing == "tower"
    own.surround([])
    MotionPlanner(own).plan(ready, down(0.45, -0.25, 0.1, 0.0), 0.25)


def test_the_table_is_kept_clear_of():
    own = ArmChain(robot_profile("ur5e"), table_height=0.12)
    with pytest.raises(BlockedError, match="the table"):
        MotionPlanner(own).plan(np.array(robot_profile("ur5e").arm.ready), down(0.45, 0.0, 0.03, 0.0), 0.25)


LIMITS = JointLimits(np.array([1.0, 0.5]), 1.5, 8.0)
joints = st.tuples(st.floats(-2, 2), st.floats(-2, 2)).map(np.array)


@given(joints, joints)
def test_a_swing_keeps_velocity_and_joins_its_ends(start: np.ndarray, goal: np.ndarray):
    timed = swing(start, goal, LIMITS)
    assert timed.positions[0] == pytest.approx(start)
    assert timed.positions[-1] == pytest.approx(goal)
    assert (np.abs(timed.velocities) <= LIMITS.velocity + 1e-6).all()
    again = joined(timed, swing(goal, start, LIMITS))
    assert again.positions[-1] == pytest.approx(start)
    assert (np.diff(again.times) > 0).all()


@given(st.floats(0.01, 1.0), st.floats(0.02, 1.0))
def test_a_way_is_never_faster_than_asked(length: float, speed: float):
    lengths = np.linspace(0.0, length, 30)
    way = np.stack((lengths, 0.1 * np.sin(lengths)), axis=1)
    timed = along(way, lengths, speed, LIMITS)
    assert timed.positions[[0, -1]] == pytest.approx(way[[0, -1]], abs=1e-6)
    assert np.abs(timed.velocities[:, 0]).max() <= speed + 1e-6


URDF = """<robot name="two"><link name="base"/><link name="a"/><link name="b"/><link name="tip"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="j2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="f" type="fixed"><parent link="b"/><child link="tip"/><origin xyz="0.2 0 0"/></joint>
<link name="extra"><visual><geometry><mesh filename="package://nowhere/x.dae"/></geometry></visual></link>
<joint name="e" type="fixed"><parent link="base"/><child link="extra"/></joint></robot>"""


def test_a_urdf_with_meshes_that_are_not_here_is_read_for_its_joints():
    spec = load_description("topic:robot_description", URDF)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = (0.5, 0.0)
    mujoco.mj_kinematics(model, data)
    assert data.body("tip").xpos == pytest.approx((0.6 * math.cos(0.5), 0.6 * math.sin(0.5), 0.3))
    assert model.jnt_range[0] == pytest.approx((-1, 1))


def test_a_description_that_is_none_is_refused():
    with pytest.raises(ModelError, match="no model 'gen4': expected one of fr3, gen3"):
        load_description("gen4")
    with pytest.raises(ModelError, match="cannot be read"):
        load_description("topic:x", "no xml")
    with pytest.raises(ModelError, match="has no link 'fr3_link8'"):
        ArmChain(robot_profile("fr3"), (MODELS / "gen3.xml").read_text())


@pytest.mark.parametrize("name", ["ur5e", "gen3"])
def test_where_the_straight_way_and_the_one_by_the_ready_pose_are_blocked_the_arm_goes_round(name: str):
    own = ArmChain(robot_profile(name))
    plans = MotionPlanner(own)
    start = plans.plan(np.array(robot_profile(name).arm.ready), down(0.42, -0.3, 0.15, 0.0), 0.25).positions[-1]
    own.surround([Obstacle("tower", (0.45, 0.0, 0.22), (0.12, 0.12, 0.44))])
    goal = down(0.42, 0.3, 0.15, 0.0)
    with pytest.raises(BlockedError):
        plans.direct(start, goal, 0.25)
    timed = plans.plan(start, goal, 0.25)
    assert own.tool_pose(timed.positions[-1]).position == pytest.approx(goal.position, abs=1e-3)
    assert (np.abs(timed.velocities) <= np.array(own.profile.arm.max_velocity) * 1.05).all()
    for q in timed.positions:
        tool = own.tool_pose(q)
        assert own.nearest(q)[0] > 0.003
        assert tool.position[2] > 0.135 and tool.rotation.as_matrix()[2, 2] < -0.75
    assert np.array_equal(plans.plan(start, goal, 0.25).positions, timed.positions)


def test_what_is_held_goes_with_the_tool_as_it_was_grasped():
    own = ArmChain(robot_profile("ur5e"))
    plans = MotionPlanner(own)
    at_grasp = plans.plan(np.array(robot_profile("ur5e").arm.ready), down(0.4, -0.2, 0.15, 0.4), 0.25).positions[-1]
    own.surround([Obstacle("wall", (0.4, 0.1, 0.1), (0.4, 0.02, 0.2))])
    # Its middle is 4 cm off the tool's axis: its side is 0.19 m from the wall's then.
    own.hold(HeldBoxes((Obstacle("pan", (0.4, -0.16, 0.12), (0.1, 0.1, 0.04), 0.0),), own.tool_pose(at_grasp)))
    assert own.held_nearest(at_grasp)[1] in ("wall", "the table")
    assert own.held_nearest(at_grasp, {"the table"}) == (pytest.approx(0.2, abs=2e-3), "wall")
    nearer = plans.plan(at_grasp, down(0.4, -0.1, 0.15, 0.4), 0.25).positions[-1]
    assert own.held_nearest(nearer, {"the table"})[0] == pytest.approx(0.1, abs=2e-3)
    own.hold(HeldBoxes())
    assert own.held_nearest(at_grasp) == (1e3, "")


@pytest.mark.parametrize("name", ["ur5e", "gen3"])
def test_a_searched_way_keeps_what_is_held_clear_too_but_for_what_it_stands_on(name: str):
    own = ArmChain(robot_profile(name))
    plans = MotionPlanner(own)
    start = plans.plan(np.array(robot_profile(name).arm.ready), down(0.42, -0.3, 0.15, 0.0), 0.25).positions[-1]
    below = Obstacle("board", (0.42, -0.3, 0.03), (0.1, 0.1, 0.06))
    own.surround([Obstacle("tower", (0.45, 0.0, 0.22), (0.12, 0.12, 0.44)), below])
    goal = down(0.42, 0.3, 0.15, 0.0)
    # It stands on the board, and reaches 12 cm to either side of the hand.
    pan = Obstacle("pan", (0.42, -0.3, 0.07), (0.24, 0.24, 0.02))
    own.hold(HeldBoxes((pan,), own.tool_pose(start)))
    assert own.touched_by_held(start, 0.005) == {"board"}
    timed = plans.plan(start, goal, 0.25)
    assert own.tool_pose(timed.positions[-1]).position == pytest.approx(goal.position, abs=1e-3)
    for q in timed.positions:
        assert own.nearest(q)[0] > 0.003
        assert own.held_nearest(q, {"board"})[0] > 0.003
    own.hold(HeldBoxes())
    empty = plans.plan(start, goal, 0.25)
    own.hold(HeldBoxes((pan,), own.tool_pose(start)))
    assert min(own.held_nearest(q, {"board"})[0] for q in empty.positions) < 0.0


@settings(max_examples=8, suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(start=places, goal=places, y=st.floats(-0.2, 0.2))
def test_no_way_leads_through_or_over_the_hand_zone_of_the_teacher(start: RobotToolPose, goal: RobotToolPose, y: float):
    own = ArmChain(robot_profile("ur5e"))
    plans = MotionPlanner(own)
    first = plans.plan(np.array(robot_profile("ur5e").arm.ready), start, 0.25).positions[-1]
    zone = hand_zone_box((0.35, 0.6, y - 0.03, y + 0.03), 0.0)
    assert zone is not None
    own.surround([zone])
    outside = own.nearest(first)[0] > 0.0
    try:
        timed = plans.plan(first, goal, 0.25)
    except (BlockedError, OutOfReachError):
        return
    tool = np.array([own.tool_pose(q).position for q in timed.positions])
    inside = (tool[:, 0] > 0.35) & (tool[:, 0] < 0.6) & (abs(tool[:, 1] - y) < 0.03)
    assert not (outside and inside.any())


def test_a_hand_zone_is_a_box_or_nothing():
    assert hand_zone_box((0.0, 0.0, 0.0, 0.0), 0.0) is None
    for wrong in ((0.5, 0.4, 0.0, 0.1), (0.1, 0.2, math.nan, 0.1), (0.1, 0.2, 0.3)):
        with pytest.raises(ParameterError, match="x_min <= x_max"):
            hand_zone_box(wrong, 0.0)


@settings(max_examples=20)
@given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9))
def test_a_searched_way_goes_through_the_gap_of_a_wall_and_none_is_made_up_where_there_is_no_gap(y: float, gap: float):
    """Two joints as the coordinates of a plane, with a wall across it."""

    def free(q: np.ndarray) -> bool:
        return abs(q[0]) > 0.1 or abs(q[1] - gap) < 0.12

    rng = np.random.default_rng(1)
    samples = rng.uniform(-1.0, 1.0, (2000, 2))
    start, goal = np.array((-0.8, y)), np.array((0.8, -y))
    way = connect(start, goal, iter(samples), free, rng)
    assert way is not None and (way[0] == start).all() and (way[-1] == goal).all()
    for one, other in itertools.pairwise(way):
        assert all(free(q) for q in between(one, other))
    assert connect(start, goal, iter(samples[:100]), lambda q: bool(abs(q[0]) > 0.1), rng) is None
