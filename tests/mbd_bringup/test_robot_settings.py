from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path

import pytest
from mbd_bringup.launch_arguments import ARGUMENTS, options_of
from mbd_bringup.nodes import NodeSpec, SessionOptions, session_nodes
from mbd_bringup.parameter_page import TABLES
from mbd_bringup.robot_settings import camera_settings, robot_settings, settings_of_robot, unrecorded
from mbd_model.errors import MbdError
from mbd_perception.arm.description import parse_description
from mbd_robot.profiles.find import camera_names, camera_profile, robot_names, robot_profile
from mbd_robot.topics import JOINT_STATE

PAIRS = [*itertools.product(robot_names(), camera_names())]
BY_NODE = {table.node: table for table in TABLES}


def nodes(robot: str, camera: str, *, simulated: bool) -> dict[str, NodeSpec]:
    options = SessionOptions("s", Path("s"), execute=True, simulated=simulated, robot=robot, camera=camera)
    return {spec.executable: spec for spec in session_nodes(options)}


@pytest.mark.parametrize(("robot", "camera"), PAIRS)
def test_every_parameter_that_a_profile_sets_is_one_that_its_node_takes(robot: str, camera: str):
    for simulated in (True, False):
        for name, spec in nodes(robot, camera, simulated=simulated).items():
            given = {k: v for k, v in spec.parameters.items() if k != "use_sim_time"}
            BY_NODE[name].values(given)


@pytest.mark.parametrize("robot", robot_names())
def test_scenes_goals_and_tool_poses_are_in_one_frame_and_the_hand_is_the_robot_s(robot: str):
    profile, made = robot_profile(robot), nodes(robot, "", simulated=False)
    frames = {made[n].parameters["base_frame"] for n in ("perception", "execution")}
    assert frames == {profile.base_frame}
    demonstration = made["demonstration"].parameters
    assert demonstration["finger_joints"] == list(profile.hand.joints)
    larger_closed = profile.hand.closed > profile.hand.open
    assert demonstration["finger_polarity"] == ("larger_closed" if larger_closed else "larger_open")
    assert made["execution"].parameters["move_tool"] == "robot/move_tool"
    assert made["execution"].parameters["look_from"] == list(profile.arm.look_from)
    assert "cell" not in made


@pytest.mark.parametrize("robot", robot_names())
def test_perception_is_given_the_model_of_the_arm_that_moves(robot: str):
    profile, made = robot_profile(robot), nodes(robot, "", simulated=False)
    given = made["perception"].parameters
    arm = parse_description(Path(str(given["arm_description"])).read_text(encoding="utf-8"))
    assert arm.movable == set(profile.arm.joints)
    assert given["joint_state"] == JOINT_STATE


def test_an_arm_that_is_described_on_a_topic_is_read_there_by_perception():
    profile = robot_profile("ur5e")
    by_topic = dataclasses.replace(profile, arm=dataclasses.replace(profile.arm, model="topic:robot_description"))
    assert "arm_description" not in settings_of_robot(by_topic).perception


@pytest.mark.parametrize("camera", camera_names())
def test_a_camera_is_passed_on_unless_it_has_the_suite_s_names_already(camera: str):
    profile, made = camera_profile(camera), nodes("", camera, simulated=True)
    assert ("camera" in made) != profile.names_are_the_suites
    assert made["cell"].parameters["camera"] == camera
    patterns = [re.compile(str(p)) for p in made["recorder"].parameters.get("exclude", ())]
    raw = f"/{profile.color.topic}"
    assert any(p.fullmatch(raw) for p in patterns) != profile.names_are_the_suites
    assert not any(p.fullmatch("/camera/color/image_raw") for p in patterns) or profile.names_are_the_suites


def test_without_a_profile_nothing_is_set():
    settings = robot_settings("")
    assert not any(dataclasses.asdict(settings).values())
    assert unrecorded(settings, camera_settings("")) == {}
    assert {"robot", "camera"} & set(nodes("", "", simulated=True)) == set()


@pytest.mark.parametrize("given", [{"robot": "ur5"}, {"camera": "/nowhere/my.camera.yaml"}])
def test_a_profile_that_cannot_be_used_ends_the_session_before_it_begins(given: dict[str, str]):
    words = {name: argument.default for name, argument in ARGUMENTS.items()} | given
    with pytest.raises(MbdError, match=r"did you mean 'ur5e'|cannot be read"):
        options_of(words)
