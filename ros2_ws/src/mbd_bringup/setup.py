"""Install mbd_bringup as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "demo = mbd_bringup.demo_command:main",
        "markers = mbd_bringup.ros.markers_node:main",
    ],
)
