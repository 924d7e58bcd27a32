from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.physics.robots import cell_robot
from mbd_robot import profile_command
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.profiles.camera import CameraProfile
from mbd_robot.profiles.find import camera_names, camera_profile, robot_names, robot_profile
from mbd_robot.profiles.reading import ProfileError, read_profile, section
from mbd_robot.profiles.robot import RobotProfile

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_robot" / "config"
ROBOT_FILES = sorted(CONFIG.glob("*.robot.yaml"))
CAMERA_FILES = sorted(CONFIG.glob("*.camera.yaml"))


def document(file: Path) -> dict[str, object]:
    return yaml.safe_load(file.read_text())


def test_the_robots_and_cameras_of_the_table_are_there():
    assert {"jaco2", "jaco2_2f85", "ada", "gen3", "ur5e", "fr3"} <= set(robot_names())
    assert {"realsense", "realsense_compressed", "orbbec", "azure_kinect", "zed", "two_topics"} <= set(camera_names())


@pytest.mark.parametrize("file", [*ROBOT_FILES, *CAMERA_FILES], ids=lambda f: f.name)
def test_a_profile_cites_its_sources_and_says_on_what_it_ran(file: Path):
    kind = RobotProfile if file in ROBOT_FILES else CameraProfile
    assert "never run on hardware" in read_profile(kind, file).tested
    if file.name != "two_topics.camera.yaml":
        assert "/" in file.read_text().partition("title:")[0], "names no repository and file"


@pytest.mark.parametrize("name", robot_names())
def test_the_ready_pose_has_the_hand_down_over_the_table_and_within_limits(name: str):
    profile = robot_profile(name)
    chain = ArmChain(profile)
    ready = profile.arm.ready
    pose = chain.tool_pose(ready)
    assert pose.rotation.as_matrix()[2, 2] < -0.99
    assert 0.3 < pose.position[0] < 0.5
    assert 0.2 < pose.position[2] < 0.4
    assert all(low <= q <= high for low, q, high in zip(chain.low, ready, chain.high, strict=True))
    assert chain.nearest(ready)[0] > 0.05


@pytest.mark.parametrize("name", robot_names())
def test_the_cell_can_play_every_robot(name: str):
    profile = robot_profile(name)
    assert profile.stand_in is not None
    robot = cell_robot(profile.stand_in.arm, profile.stand_in.hand)
    assert len(robot.arm.joints) == len(profile.arm.joints)


@pytest.mark.parametrize("file", ROBOT_FILES, ids=lambda f: f.name)
@given(data=st.data())
def test_a_misspelt_key_is_refused_with_the_right_one(file: Path, data: st.DataObject):
    content = document(file)
    key = data.draw(st.sampled_from(sorted(content)))
    content[f"{key}_x"] = content.pop(key)
    with pytest.raises(ProfileError, match=f"no key '{key}_x'; did you mean '{key}'"):
        section(RobotProfile, content, "my.robot.yaml")


@pytest.mark.parametrize("file", ROBOT_FILES, ids=lambda f: f.name)
def test_a_lacking_key_is_named(file: Path):
    for field in dataclasses.fields(RobotProfile):
        content = document(file)
        if content.pop(field.name, None) is None or field.name in ("packages", "stand_in", "safety"):
            continue
        with pytest.raises(ProfileError, match=f"my.yaml lacks the key '{field.name}'"):
            section(RobotProfile, content, "my.yaml")


@pytest.mark.parametrize(
    ("where", "value", "expected"),
    [
        (("arm", "interface"), "follow_joint_trajectori", "did you mean 'follow_joint_trajectory'"),
        (("arm", "ready"), [0.0], "ready has 1 numbers for 6 joints"),
        (("arm", "max_velocity"), [0.0] * 6, "must be above 0"),
        (("hand", "closed"), 0.0, "open and closed are equal"),
        (("hand", "joints"), "robotiq_85_left_knuckle_joint", "expected a list"),
        (("joint_states", "rate"), "fast", "expected a number"),
        (("joint_states", "topics"), [], "topics is empty"),
        (("tool_pose", "source"), "topic", "source is topic, and no topic is given"),
        (("tool_pose", "offset"), [0.0, 0.1], "has 2 entries; expected 3"),
        (("guiding", "switch"), "controllers", None),
        (("guiding",), {"switch": "person"}, "no instruction is given"),
        (("guiding",), {True: "x", "switch": "person"}, "no key 'True'"),
        (("arm",), 7, "expected keys such as"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(where: tuple[str, ...], value: object, expected: str | None):
    content = document(CONFIG / "ur5e.robot.yaml")
    inner = content
    for key in where[:-1]:
        inner = inner[key]  # type: ignore[assignment]
    inner[where[-1]] = value
    if expected is None:
        section(RobotProfile, content, "my.yaml")
        return
    with pytest.raises(ProfileError, match=r"my\.yaml") as refused:
        section(RobotProfile, content, "my.yaml")
    assert expected in str(refused.value)
    assert where[0] in str(refused.value)


def test_depth_in_jpeg_is_refused():
    content = document(CONFIG / "realsense.camera.yaml")
    content["depth"]["transport"] = "compressed"  # type: ignore[index]
    with pytest.raises(ProfileError, match="JPEG spoils depth"):
        section(CameraProfile, content, "my.yaml")


def test_a_file_of_ones_own_is_as_good_as_a_name(tmp_path: Path):
    mine = tmp_path / "mine.yaml"
    mine.write_text((CONFIG / "gen3.robot.yaml").read_text())
    assert robot_profile(str(mine)) == robot_profile("gen3")


@pytest.mark.parametrize("text", ["- a", "a: [", "", "\x00"])
def test_a_file_that_is_no_profile_is_refused_in_one_sentence(tmp_path: Path, text: str):
    mine = tmp_path / "mine.yaml"
    mine.write_text(text)
    with pytest.raises(ProfileError, match=r"mine\.yaml"):
        robot_profile(str(mine))


def test_a_name_that_is_none_is_refused_with_the_nearest():
    with pytest.raises(ProfileError, match="no robot 'jacco2'; did you mean 'jaco2'"):
        robot_profile("jacco2")
    with pytest.raises(ProfileError, match="no camera 'webcam'; there are: "):
        camera_profile("webcam")
    with pytest.raises(ProfileError, match="cannot be read"):
        camera_profile("nowhere/camera.yaml")


def test_the_command_prints_them_and_refuses_a_wrong_one(capsys: pytest.CaptureFixture[str]):
    profile_command.main([])
    assert all(name in capsys.readouterr().out or name for name in robot_names())
    profile_command.main(["--robot", "fr3"])
    assert "fr3_arm_controller/follow_joint_trajectory" in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        profile_command.main(["--camera", "zedd"])
    assert ended.value.code == 1
    assert "did you mean 'zed'" in capsys.readouterr().err
