"""The demonstration node's parameters, and the config they make. What the core has a default for comes from there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity
from mbd_demonstration.recording import DemonstrationConfig, GripperSource

_FINGER, _GEOMETRY = FingerJointConfig(), StepSegmentationConfig()

DEMONSTRATION = ParameterTable(
    "demonstration",
    (
        ParameterSpec(
            "gripper_source",
            GripperSource.SPOKEN.value,
            "Where gripper events come from: wizard/gripper or a joint.",
            choices=tuple(GripperSource),
        ),
        ParameterSpec(
            "finger_polarity", _FINGER.polarity.value, "What a larger finger position means.", choices=tuple(Polarity)
        ),
        ParameterSpec(
            "finger_open_level",
            _FINGER.open_level,
            "Joint position of the open hand: says the polarity; NaN: not known.",
        ),
        ParameterSpec(
            "finger_closed_level", _FINGER.closed_level, "Joint position of the closed hand; NaN: not known."
        ),
        ParameterSpec(
            "finger_min_turn",
            _FINGER.min_turn,
            "Share of their recorded range that the fingers go, and come back, to have closed and opened.",
            range=(0.01, 1.0),
        ),
        ParameterSpec(
            "finger_deep", _FINGER.deep, "A closing by this share of the range counts however short.", range=(0.05, 1.0)
        ),
        ParameterSpec("finger_rest", _FINGER.rest, "A shallower closing rests this long.", "s", range=(0.0, 10.0)),
        ParameterSpec(
            "finger_settle",
            _FINGER.settle,
            "Share of a turn within which the fingers have arrived at its level.",
            range=(0.001, 0.5),
        ),
        ParameterSpec("finger_debounce", _FINGER.debounce, "Shorter changes are glitches.", "s", range=(0.0, 2.0)),
        ParameterSpec(
            "finger_min_travel", _FINGER.min_travel, "With a smaller range the hand never moved.", range=(0.0, 1e3)
        ),
        ParameterSpec(
            "grasp_reach", _GEOMETRY.grasp_reach, "A grasped object is this near the tool.", "m", range=(0.0, 1.0)
        ),
        ParameterSpec(
            "onto_margin",
            _GEOMETRY.onto_margin,
            "A held object's centre is this near what it is put onto.",
            "m",
            range=(0.0, 0.5),
        ),
        ParameterSpec(
            "onto_clearance",
            _GEOMETRY.onto_clearance,
            "A held object's bottom is at most this far above what it is put onto.",
            "m",
            (0.0, 0.5),
        ),
        ParameterSpec(
            "regrasp_travel",
            _GEOMETRY.regrasp_travel,
            "An object let go before it moved this far was grasped again.",
            "m",
            range=(0.0, 0.5),
        ),
        ParameterSpec(
            "lift",
            _GEOMETRY.lift,
            "A gripped object is lifted this far; a closed hand that never rises pushed.",
            "m",
            range=(0.0, 0.5),
        ),
        ParameterSpec(
            "drop",
            _GEOMETRY.drop,
            "An object let go higher above all below it was handed over in the air.",
            "m",
            range=(0.0, 2.0),
        ),
        ParameterSpec(
            "distance_noise",
            _GEOMETRY.distance_noise,
            "Standard deviation of a distance between tool and object: what makes a near tie doubtful.",
            "m",
            range=(0.0, 0.1),
        ),
        ParameterSpec(
            "max_pose_gap", _GEOMETRY.max_pose_gap, "Tool poses are this near an event.", "s", range=(0.0, 60.0)
        ),
        ParameterSpec(
            "finger_joints",
            tuple(f"j2n6s300_joint_finger_{k}" for k in (1, 2, 3)),
            "Joints of out/joint_state that are the gripper's, with or without prefix; where none is, by name.",
        ),
        ParameterSpec("tool_pose", "j2n6s300_driver/out/tool_pose", "Topic of the tool's pose in the scenes' frame."),
        ParameterSpec("joint_state", "j2n6s300_driver/out/joint_state", "Topic of the joints, for finger events."),
        ParameterSpec("state_dir", "", "Folder that keeps the task over a restart; empty: not kept."),
    ),
)


def demonstration_config(values: Mapping[str, Any]) -> DemonstrationConfig:
    """How a recording becomes a task.

    Args:
        values: of the parameters of DEMONSTRATION, by name.

    Raises:
        MbdError: values that cannot go together.
    """
    finger = {f.name: values[f"finger_{f.name}"] for f in fields(FingerJointConfig)}
    return DemonstrationConfig(
        GripperSource(values["gripper_source"]),
        FingerJointConfig(**finger | {"polarity": Polarity(finger["polarity"])}),
        StepSegmentationConfig(**{f.name: values[f.name] for f in fields(StepSegmentationConfig)}),
    )
