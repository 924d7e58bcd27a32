"""The execution node's parameters, and the config they make."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_execution.hand import HandConfig

EXECUTION = ParameterTable(
    "execution",
    (
        ParameterSpec("state_dir", "", "Folder that keeps the progress over a restart; empty: not kept."),
        ParameterSpec("move_tool", "cell/move_tool", "Action that moves the tool to a pose."),
        ParameterSpec("move_gripper", "cell/move_gripper", "Action that opens or closes the hand."),
        ParameterSpec(
            "joint_state",
            "j2n6s300_driver/out/joint_state",
            "Topic of the joints, whose silence stops the robot; empty: this robot gives none, nothing watches it.",
        ),
        ParameterSpec(
            "heartbeat", 0.5, "Without a new joint state for so long the robot stops.", "s", range=(0.1, 60.0)
        ),
        ParameterSpec("base_frame", "j2n6s300_link_base", "Frame of the scenes and of the goals."),
        ParameterSpec("widest_grasp", HandConfig.widest, "A wider object is taken by its rim.", "m", range=(0.0, 0.5)),
        ParameterSpec("highest_tool", HandConfig.highest, "The tool goes at most this high.", "m", range=(0.0, 2.0)),
    ),
)


def hand_config(values: Mapping[str, Any]) -> HandConfig:
    """The hand's measures, from values of the parameters of EXECUTION by name."""
    return HandConfig(widest=values["widest_grasp"], highest=values["highest_tool"])
