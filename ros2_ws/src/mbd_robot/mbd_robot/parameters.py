"""The parameters of the robot node and of the camera node."""

from __future__ import annotations

from mbd_model.parameters import ParameterSpec, ParameterTable

ROBOT = ParameterTable(
    "robot",
    (
        ParameterSpec("robot", "jaco2", "Name of the robot's profile, or path of a file of your own."),
        ParameterSpec("speed", 0.0, "Largest speed of the tool; 0: as each goal asks.", "m/s", range=(0.0, 2.0)),
        ParameterSpec(
            "table_height", 0.0, "Of the table's top in the base frame, to keep clear of.", "m", range=(-2.0, 2.0)
        ),
        ParameterSpec("keep_clear", True, "Keep the arm's links clear of the objects that perception sees."),
        ParameterSpec(
            "hand_zone",
            (0.0, 0.0, 0.0, 0.0),
            "Box x_min, x_max, y_min, y_max [m] of the teacher's hands, which the arm keeps out of; all 0: none.",
        ),
        ParameterSpec(
            "lost_after", 2.0, "Without joint states for so long the driver counts as lost.", "s", range=(0.1, 60.0)
        ),
        ParameterSpec(
            "rate", 50.0, "Tool poses and joint states passed on, at most.", "Hz", range=(1.0, 1000.0)
        ),
    ),
)  # fmt: skip

CAMERA = ParameterTable(
    "camera",
    (
        ParameterSpec("camera", "realsense", "Name of the camera's profile, or path of a file."),
        ParameterSpec("rate", 10.0, "Frames passed on, at most.", "Hz", range=(0.1, 60.0)),
    ),
)
