"""A simulated Jaco2 tabletop cell: arm, gripper, RGB-D camera, objects, scripted teacher and wizard."""

import os
from ctypes.util import find_library

# How to render without a display. MuJoCo reads this once, when it is imported, and if it is not set wants a window.
if not os.environ.get("MUJOCO_GL"):
    os.environ["MUJOCO_GL"] = "osmesa" if find_library("OSMesa") else "egl"
