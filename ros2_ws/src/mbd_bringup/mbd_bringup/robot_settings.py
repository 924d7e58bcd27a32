"""What a robot's and a camera's profile mean for the nodes of a session."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from mbd_robot.model_files import model_file
from mbd_robot.profiles.camera import CameraProfile
from mbd_robot.profiles.find import camera_profile, robot_profile
from mbd_robot.profiles.robot import Reliability, RobotProfile
from mbd_robot.topics import JOINT_STATE, MOVE_GRIPPER, MOVE_TOOL, TOOL_POSE

Parameter = str | int | float | bool | Sequence[str] | Sequence[float]
# What is never recorded, as the recorder's own default has it.
HIDDEN = ".*/_[^/]*(/.*)?"


@dataclass(frozen=True)
class RobotSettings:
    """Parameters of the nodes, by name; empty where the suite's own topics are spoken.

    Attributes:
        perception, demonstration, execution: of the node of that name.
        repeated: topics of the drivers that the robot node passes on under the suite's names.
    """

    perception: dict[str, Parameter] = field(default_factory=dict)
    demonstration: dict[str, Parameter] = field(default_factory=dict)
    execution: dict[str, Parameter] = field(default_factory=dict)
    repeated: tuple[str, ...] = ()


@dataclass(frozen=True)
class CameraSettings:
    """What a camera's profile means.

    Attributes:
        perception: parameters of that node, by name.
        repeated: topics of the driver that the camera node passes on; none: it is not needed.
        reliable: lost fragments of its images are sent again.
    """

    perception: dict[str, Parameter] = field(default_factory=dict)
    repeated: tuple[str, ...] = ()
    reliable: bool = True


def robot_settings(name: str) -> RobotSettings:
    """What the robot of that name or file means; nothing for "". Raises MbdError for a profile that cannot be used."""
    return settings_of_robot(robot_profile(name)) if name else RobotSettings()


def camera_settings(name: str) -> CameraSettings:
    """What the camera of that name or file means; nothing for "". Raises MbdError as ``robot_settings``."""
    return settings_of_camera(camera_profile(name)) if name else CameraSettings()


def settings_of_robot(profile: RobotProfile) -> RobotSettings:
    """What a profile means for the nodes."""
    hand = profile.hand
    return RobotSettings(
        perception={"base_frame": profile.base_frame, "joint_state": JOINT_STATE, **_description(profile)},
        demonstration={
            "tool_pose": TOOL_POSE,
            "joint_state": JOINT_STATE,
            "finger_joints": list(hand.joints),
            "gripper_source": hand.events.value,
            "finger_polarity": "larger_closed" if hand.closed > hand.open else "larger_open",
            "finger_open_level": hand.open,
            "finger_closed_level": hand.closed,
        },
        execution={
            "move_tool": MOVE_TOOL,
            "move_gripper": MOVE_GRIPPER,
            "joint_state": JOINT_STATE,
            "base_frame": profile.base_frame,
            "widest_grasp": hand.widest_grasp,
            "highest_tool": profile.arm.highest_tool,
            "look_from": [float(v) for v in profile.arm.look_from],
        },
        repeated=(profile.tool_pose.topic,) if profile.tool_pose.topic else (),
    )


def _description(profile: RobotProfile) -> dict[str, Parameter]:
    """By what perception tells the arm from objects; to one that comes on a topic it subscribes itself."""
    if profile.arm.description_topic:
        return {}
    return {"arm_description": str(model_file(profile.arm.model).resolve())}


def settings_of_camera(profile: CameraProfile) -> CameraSettings:
    """What a profile means for perception, and for the recorder."""
    topics = (profile.color.topic, profile.depth.topic, profile.camera_info)
    return CameraSettings(
        perception={"depth_noise": profile.depth_noise, "sync_tolerance": profile.sync_tolerance},
        repeated=() if profile.names_are_the_suites else topics,
        reliable=profile.reliability is Reliability.RELIABLE,
    )


def unrecorded(robot: RobotSettings, camera: CameraSettings) -> dict[str, Parameter]:
    """The recorder's ``exclude``: the suite's names hold the same already; {} where nothing is passed on."""
    repeated = (*robot.repeated, *camera.repeated)
    if not repeated:
        return {}
    return {"exclude": [HIDDEN, *(f"/?{re.escape(topic)}(/compressed|/compressedDepth)?" for topic in repeated)]}
