"""The parameters of the cell and of its scripted wizard."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.camera.parameters import CAMERA_ORIENTATION, CAMERA_POSITION
from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_cell.physics.camera_pose import CELL_CAMERA_ORIENTATION, CELL_CAMERA_POSITION
from mbd_cell.physics.grasp import Grasp

_SCENE_DIR = ParameterSpec("scene_dir", "", "Folder of the scene files; empty: this package's config folder.")

CELL = ParameterTable(
    "cell",
    (
        ParameterSpec(
            "teacher",
            "scripted",
            "Who demonstrates: scripted, or none, for an operator of the actions.",
            choices=("scripted", "none"),
        ),
        _SCENE_DIR,
        ParameterSpec("task", "sorting", "Name of the scene file (without .yaml) to lay."),
        ParameterSpec("seed", 1, "Of every random choice: layout, guiding hand, noise.", range=(0, 2**31 - 1)),
        ParameterSpec(
            "speed",
            1.0,
            "Simulated over wall time while something moves; 0: as fast as it can. At rest it is 1 at most.",
            range=(0.0, 1000.0),
        ),
        ParameterSpec(
            "camera_rate",
            4.0,
            "Images a simulated second while nothing moves, if anybody listens.",
            "Hz",
            range=(0.05, 30.0),
        ),
        ParameterSpec(
            "camera_rate_moving", 0.5, "Images a simulated second while the arm moves.", "Hz", range=(0.05, 30.0)
        ),
        ParameterSpec(
            "grasp",
            Grasp.WELD.value,
            "What keeps an object in the hand: friction, the fingers' pressure only; weld, fixed to the hand as soon "
            "as opposed fingers touch it.",
            choices=tuple(g.value for g in Grasp),
        ),
        ParameterSpec("noise", True, "Structured-light depth noise and colour grain."),
        replace(CAMERA_POSITION, default=CELL_CAMERA_POSITION),
        replace(CAMERA_ORIENTATION, default=CELL_CAMERA_ORIENTATION),
        ParameterSpec(
            "robot",
            "",
            "Robot whose drivers the cell plays: name of a profile of mbd_robot, or path of a file; empty: none, the "
            "suite's own topics.",
        ),
        ParameterSpec("camera", "", "Camera whose driver the cell plays, alike."),
        ParameterSpec("driver", "j2n6s300_driver", "Namespace of the arm driver's topics."),
        ParameterSpec(
            "reminder",
            3.0,
            "The teacher repeats a word unanswered so long, then after twice that, up to 5 times that; wall clock.",
            "s",
            range=(0.5, 60.0),
        ),
    ),
)

WIZARD = ParameterTable(
    "wizard",
    (
        ParameterSpec(
            "wrong_step", -1, "Index of the step whose assist is wrong on purpose; -1: none.", range=(-1, 1000)
        ),
        ParameterSpec(
            "reply_timeout",
            30.0,
            "An event without a reply is sent again after so long, wall clock.",
            "s",
            range=(0.1, 600.0),
        ),
        _SCENE_DIR,
    ),
)
