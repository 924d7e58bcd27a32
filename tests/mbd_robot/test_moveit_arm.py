"""Motions by MoveIt 2: what its MoveGroup is asked, and what its answers mean; real messages, a scripted server."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from cell_and_robot import Playground, played, playground
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.errors import MbdError
from mbd_model.stop import MotionError
from mbd_msgs.action import MoveTool
from mbd_robot.geometry import HeldBoxes, Obstacle, RobotToolPose, Surroundings
from mbd_robot.profiles.find import robot_profile
from mbd_robot.profiles.moveit import MoveItProfile
from mbd_robot.profiles.reading import ProfileError
from mbd_robot.profiles.robot import ArmInterface, RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.moving.moveit_arm import MoveGroupArm, distance
from mbd_robot.ros.moving.moveit_held import HeldInMoveIt, in_tip
from mbd_robot.ros.tool_frames import pose_from_msg, suite_pose
from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future
from scipy.spatial.transform import Rotation
from trajectory_msgs.msg import JointTrajectoryPoint

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_robot" / "config"
DOWN = np.array((1.0, 0.0, 0.0, 0.0))
GOAL = RobotToolPose(np.array((0.4, 0.1, 0.25)), DOWN)
NOW = RobotToolPose(np.array((0.5, 0.0, 0.4)), DOWN)
SUCCESS, PLANNING_FAILED, CONTROL_FAILED, INVALID_GROUP = 1, -1, -4, -15


def by_moveit(group: str = "ur_manipulator", touch_links: tuple[str, ...] = ("finger",)) -> RobotProfile:
    profile = robot_profile("ur5e")
    moveit = MoveItProfile(group=group, touch_links=touch_links)
    arm = replace(profile.arm, interface=ArmInterface.MOVE_GROUP, action="move_action", moveit=moveit)
    return replace(profile, arm=arm, safety=())


class Scripted:
    """A MoveGroup that answers as it is told, and an arm that asks it."""

    def __init__(self, there: Playground) -> None:
        self.there = there
        self.kind = interface("moveit_msgs", "action", "MoveGroup")
        self.goals: list[Any] = []
        self.answers: list[tuple[int, bool]] = []  # the error code, and whether a plan was found
        self.held: Future[None] | None = None
        self.boxes: list[Obstacle] = []
        self.in_hand = HeldBoxes()
        self.scenes: list[Any] = []
        there.node.create_subscription(
            interface("moveit_msgs", "msg", "PlanningScene"), "planning_scene", self.scenes.append, 10
        )
        self.server = ActionServer(
            there.node, self.kind, "move_action", self._run, cancel_callback=lambda _: CancelResponse.ACCEPT
        )
        self.arm = MoveGroupArm(there.node, by_moveit(), lambda: NOW, self._around, 0.0)
        there.until(lambda: not self.arm.ready())

    def _around(self) -> Surroundings:
        return Surroundings(tuple(self.boxes), self.in_hand)

    async def _run(self, handle: Any) -> Any:
        self.goals.append(handle.request)
        if self.held is not None:
            await self.held
        code, planned = self.answers.pop(0)
        result = self.kind.Result()
        result.error_code.val = code
        if planned:
            result.planned_trajectory.joint_trajectory.points = [JointTrajectoryPoint()]
        if handle.is_cancel_requested:
            handle.canceled()
        elif code == SUCCESS:
            handle.succeed()
        else:
            handle.abort()
        return result

    def moved(self, *answers: tuple[int, bool], speed: float = 0.2) -> Any:
        self.answers = list(answers)
        task = self.there.executor.create_task(self.arm.move(GOAL, speed))
        self.there.until(task.done)
        return task.result()


@pytest.fixture
def scripted(ros_domain: int) -> Iterator[Scripted]:
    with playground(ros_domain) as there:
        yield Scripted(there)


def test_the_straight_way_is_asked_for_first_at_the_goal_s_speed_and_with_the_hand_at_the_tip(scripted: Scripted):
    assert scripted.moved((SUCCESS, True)).success
    request = scripted.goals[0].request
    assert (request.pipeline_id, request.planner_id) == ("pilz_industrial_motion_planner", "LIN")
    assert request.group_name == "ur_manipulator"
    assert request.max_velocity_scaling_factor == pytest.approx(0.2)
    assert request.start_state.is_diff
    constraints = request.goal_constraints[0]
    position, turned = constraints.position_constraints[0], constraints.orientation_constraints[0]
    assert {position.link_name, turned.link_name} == {"tool0"}
    assert {position.header.frame_id, turned.header.frame_id} == {"base_link"}
    pose = position.constraint_region.primitive_poses[0]
    pose.orientation = turned.orientation
    tool = suite_pose(pose_from_msg(pose), by_moveit().tool_pose)
    assert tool.position == pytest.approx(GOAL.position, abs=1e-9)
    assert abs(tool.quaternion @ GOAL.quaternion) == pytest.approx(1.0)


def test_the_table_and_the_boxes_are_its_scene_but_for_what_the_hand_reaches_for(scripted: Scripted):
    taken = Obstacle("t1", (0.42, 0.1, 0.2), (0.06, 0.06, 0.1))
    beside = Obstacle("t2", (0.4, -0.3, 0.05), (0.06, 0.08, 0.1), 0.7)
    scripted.boxes = [taken, beside]
    scripted.moved((SUCCESS, True))
    scene = scripted.goals[0].planning_options.planning_scene_diff
    assert scene.is_diff
    things = {thing.id: thing for thing in scene.world.collision_objects}
    assert set(things) == {"table", "t2"}
    table = things["table"]
    top = table.primitive_poses[0].position.z + table.primitives[0].dimensions[2] / 2
    assert -0.02 < top < 0.0
    assert list(things["t2"].primitives[0].dimensions) == pytest.approx(beside.size)
    assert distance(taken, GOAL.position) == 0.0
    assert distance(beside, np.array((0.4, -0.3, 0.3))) == pytest.approx(0.2)


@given(
    st.tuples(*[st.floats(-0.8, 0.8)] * 3),
    st.tuples(*[st.floats(-0.8, 0.8)] * 3),
    st.floats(-1.5, 1.5),
    st.floats(-3.0, 3.0),
)
def test_a_held_box_is_where_it_was_taken_when_the_tip_is_there_again(place, centre, yaw, turn):
    tip = RobotToolPose(np.array(place), (Rotation.from_euler("z", turn) * Rotation.from_quat(DOWN)).as_quat())
    taken = Obstacle("t1", centre, (0.06, 0.08, 0.1), yaw)
    pose = pose_from_msg(in_tip(taken, tip))
    assert tip.position + tip.rotation.apply(pose.position) == pytest.approx(centre, abs=1e-9)
    turned = tip.rotation * pose.rotation
    assert (turned.inv() * Rotation.from_euler("z", yaw)).magnitude() == pytest.approx(0.0, abs=1e-7)


def test_what_is_held_is_attached_once_and_detached_once_let_go(scripted: Scripted):
    box = Obstacle("t1", (0.5, 0.0, 0.35), (0.06, 0.08, 0.1), 0.3)
    for held in (HeldBoxes(), HeldBoxes((box,), NOW), HeldBoxes((box,), NOW), HeldBoxes()):
        scripted.in_hand = held
        scripted.moved((SUCCESS, True))
    scripted.there.until(lambda: len(scripted.scenes) == 2)
    taken, gone = scripted.scenes
    assert taken.is_diff and taken.robot_state.is_diff
    (attached,) = taken.robot_state.attached_collision_objects
    assert (attached.link_name, list(attached.touch_links)) == ("tool0", ["finger"])
    assert attached.object.header.frame_id == "tool0"
    assert attached.object.operation == attached.object.ADD
    assert np.array(attached.object.primitives[0].dimensions) == pytest.approx(np.array(box.size) - 0.01)
    # What MoveIt makes a thing of the world when it is detached goes from there, too.
    (detached,), (left,) = gone.robot_state.attached_collision_objects, gone.world.collision_objects
    assert (detached.object.id, left.id) == (attached.object.id, attached.object.id)
    assert (detached.object.operation, left.operation) == (left.REMOVE, left.REMOVE)


def test_without_the_hand_s_links_nothing_is_attached_for_the_hand_itself_would_touch_it(ros_domain: int):
    with playground(ros_domain) as there:
        received: list[Any] = []
        kind = interface("moveit_msgs", "msg", "PlanningScene")
        there.node.create_subscription(kind, "planning_scene", received.append, 10)
        held = HeldInMoveIt(there.node, by_moveit(touch_links=()))
        held.tell(HeldBoxes((Obstacle("t1", (0.5, 0.0, 0.35), (0.06, 0.08, 0.1)),), NOW))
        assert there.node.count_publishers("planning_scene") == 0
        assert not received


def test_the_next_planner_is_asked_where_one_finds_no_way_and_no_further(scripted: Scripted):
    assert scripted.moved((PLANNING_FAILED, False), (SUCCESS, True)).success
    asked = [(g.request.pipeline_id, g.request.planner_id) for g in scripted.goals]
    assert asked == [("pilz_industrial_motion_planner", "LIN"), ("pilz_industrial_motion_planner", "PTP")]


def test_where_none_finds_a_way_that_is_said_and_may_be_tried_again(scripted: Scripted):
    with pytest.raises(MbdError, match=r"LIN: no plan was found.*ompl/: there is no such planning group: see moveit"):
        scripted.moved((PLANNING_FAILED, False), (PLANNING_FAILED, False), (INVALID_GROUP, False))
    assert len(scripted.goals) == 3


def test_a_motion_that_is_given_up_on_its_way_is_a_protective_stop_and_no_other_planner_is_tried(scripted: Scripted):
    end = scripted.moved((CONTROL_FAILED, True))
    assert (end.success, end.code) == (False, MotionError.PROTECTIVE_STOP)
    assert "MoveItErrorCodes -4" in end.message
    assert len(scripted.goals) == 1


def test_a_motion_is_stopped_on_request(scripted: Scripted):
    scripted.held = Future(executor=scripted.there.executor)
    scripted.answers = [(-7, True)]
    task = scripted.there.executor.create_task(scripted.arm.move(GOAL, 0.2))
    scripted.there.until(lambda: bool(scripted.goals))
    # The answer that the goal is taken may still be on its way.
    scripted.arm.cancel()
    for _ in range(20):
        scripted.there.executor.spin_once(timeout_sec=0.01)
    scripted.held.set_result(None)
    scripted.there.until(task.done)
    assert task.result().code is MotionError.CANCELED


def test_the_interface_and_its_section_belong_together(tmp_path: Path):
    content = yaml.safe_load((CONFIG / "ur5e.robot.yaml").read_text())
    content["arm"]["interface"] = "move_group"
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(content))
    with pytest.raises(ProfileError, match="move_group and the section moveit belong together"):
        robot_profile(str(file))
    content["arm"]["moveit"] = {"group": "ur_manipulator", "planners": ["LIN"]}
    file.write_text(yaml.safe_dump(content))
    with pytest.raises(ProfileError, match="planners has 'LIN'; expected pipeline/planner"):
        robot_profile(str(file))


def test_the_cell_s_arm_goes_where_moveit_is_asked_to_bring_it(ros_domain: int, tmp_path: Path):
    content = yaml.safe_load((CONFIG / "ur5e.robot.yaml").read_text())
    content["arm"] |= {"interface": "move_group", "action": "move_action", "moveit": {"group": "ur_manipulator"}}
    file = tmp_path / "ur5e_by_moveit.yaml"
    file.write_text(yaml.safe_dump(content))
    with played(ros_domain, str(file)) as there:
        # From the folded arm there is no straight way: another planner finds one. The second is straight.
        for goal in ((0.4, -0.12, 0.3), (0.45, 0.1, 0.25)):
            result = there.move(*goal)
            assert result.success, result.message
            p = result.reached.position
            assert (p.x, p.y, p.z) == pytest.approx(goal, abs=0.01)
        away = there.move(2.0, 0.0, 0.3)
        assert away.error_code == MoveTool.Result.NOT_REACHED
        assert "MoveIt finds no way" in away.message
