"""The cell renders where there is no display, and reports it where it cannot."""

from __future__ import annotations

import os
import subprocess
import sys

RENDER = """
from mbd_cell.physics.camera import Camera
from mbd_model.errors import MbdError
import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><visual><global offwidth='640' offheight='480'/></visual><worldbody/></mujoco>"
)
try:
    with Camera(model):
        print("rendered")
except MbdError as error:
    print("refused:", error)
"""


def rendering(**variables: str) -> str:
    """What a process states that renders with these variables and without a display."""
    unset = ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {k: v for k, v in os.environ.items() if k not in unset} | variables
    done = subprocess.run([sys.executable, "-c", RENDER], env=environment, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def test_it_renders_without_a_display_and_without_being_assisted_how():
    assert rendering().endswith("rendered\n")


def test_a_way_of_rendering_that_does_not_work_is_refused_with_what_to_set_and_install():
    output = rendering(MUJOCO_GL="glfw")
    assert "refused: cannot render" in output
    assert "set MUJOCO_GL to osmesa or egl" in output
