"""The execution node's parameters, and the config they make."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from mbd_model.parameters import ParameterError, ParameterSpec, ParameterTable

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
        ParameterSpec(
            "look_again", True, "Look at the table before every step; off: believe that nothing but the robot moves it."
        ),
        ParameterSpec("observe", "perception/observe", "Service that looks at the table."),
        ParameterSpec(
            "look_from",
            HandConfig.look_from,
            "Tool position x, y, z [m] and turn [rad], fingers down, with the arm out of the camera's view.",
        ),
        ParameterSpec(
            "hand_zone",
            HandConfig.hand_zone,
            "Box x_min, x_max, y_min, y_max [m] of the teacher's hands, over which nothing passes; all 0: none.",
        ),
        ParameterSpec("highest_tool", HandConfig.highest, "The tool goes at most this high.", "m", range=(0.0, 2.0)),
    ),
)


def hand_config(values: Mapping[str, Any]) -> HandConfig:
    """The hand's measures, from values of the parameters of EXECUTION by name.

    Raises:
        ParameterError: look_from or hand_zone are not four numbers, or no box.
    """
    return HandConfig(
        widest=values["widest_grasp"],
        highest=values["highest_tool"],
        look_from=_numbers("look_from", values["look_from"]),
        hand_zone=_numbers("hand_zone", values["hand_zone"]),
    )


def _numbers(name: str, given: Sequence[float]) -> tuple[float, float, float, float]:
    """Four numbers of a parameter; raises ParameterError when they are not, or no box."""
    if len(given) != 4 or not all(math.isfinite(v) for v in given):
        raise ParameterError(f"{name} is {list(given)}: expected four finite numbers")
    if name == "hand_zone" and (given[0] > given[1] or given[2] > given[3]):
        raise ParameterError(f"hand_zone is {list(given)}: expected x_min <= x_max and y_min <= y_max [m]")
    return (float(given[0]), float(given[1]), float(given[2]), float(given[3]))
