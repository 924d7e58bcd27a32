"""The parameters of the demonstration node, declared once and handed to the core as one frozen config."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

from mbd_model.errors import MbdError
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity
from mbd_demonstration.recording import DemonstrationConfig, GripperSource

JACO_FINGERS = [f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)]


def declare_config(node: Node) -> tuple[DemonstrationConfig, list[str], str]:
    """Declare every parameter; returns the core's config, the finger joints' names and the state folder.

    Raises:
        MbdError: a value that is none of its choices, or values that cannot go together.
    """

    def declare(name: str, default: Any, description: str, **bounds: Any) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True, **bounds)
        return node.declare_parameter(name, default, descriptor).value

    def number(name: str, default: float, high: float, description: str) -> float:
        bounds = [FloatingPointRange(from_value=0.0, to_value=high)]
        return declare(name, default, description, floating_point_range=bounds)

    def choice(kind: type[StrEnum], name: str, default: str, description: str) -> Any:
        value = declare(name, default, f"{description}; one of: {', '.join(kind)}")
        if value not in list(kind):
            raise MbdError(f"parameter {name} is '{value}'; expected one of: {', '.join(kind)}")
        return kind(value)

    finger, geometry = FingerJointConfig(), StepSegmentationConfig()
    config = DemonstrationConfig(
        choice(GripperSource, "gripper_source", "spoken", "where gripper events come from: wizard/gripper or a joint"),
        FingerJointConfig(
            polarity=choice(Polarity, "finger_polarity", finger.polarity, "what a larger finger position means"),
            open_level=declare("finger_open_level", math.nan, "joint position of the open hand; NaN: learn it"),
            closed_level=declare("finger_closed_level", math.nan, "joint position of the closed hand; NaN: learn it"),
            close_at=number("finger_close_at", finger.close_at, 1.0, "closure from which on the gripper is closed"),
            open_at=number("finger_open_at", finger.open_at, 1.0, "closure down to which the gripper is open"),
            debounce=number("finger_debounce", finger.debounce, 2.0, "[s] shorter changes are glitches"),
            min_travel=number("finger_min_travel", finger.min_travel, 1e3, "a smaller range: it never moved"),
        ),
        StepSegmentationConfig(
            grasp_reach=number("grasp_reach", geometry.grasp_reach, 1.0, "[m] a grasped object is this near the tool"),
            onto_margin=number(
                "onto_margin", geometry.onto_margin, 0.5, "[m] a held object's centre is this near what it is put onto"
            ),
            onto_clearance=number(
                "onto_clearance", geometry.onto_clearance, 0.5, "[m] and its bottom at most this far above that"
            ),
            regrasp_travel=number(
                "regrasp_travel", geometry.regrasp_travel, 0.5, "[m] let go before it moved this far: grasped anew"
            ),
            max_pose_gap=number("max_pose_gap", geometry.max_pose_gap, 60.0, "[s] tool poses are this near an event"),
        ),
    )
    joints = declare("finger_joints", JACO_FINGERS, "joints of out/joint_state whose mean position is the gripper's")
    return config, list(joints), declare("state_dir", "", "folder that keeps the task over a restart; empty: not kept")
