"""Install mbd_bringup as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "calibration_bag = mbd_bringup.ros.calibration_bag:main",
        "chaos = mbd_bringup.ros.chaos.trials:main",
        "demo = mbd_bringup.demo_command:main",
        "hostile_messages = mbd_bringup.ros.hostile.hostile_trials:main",
        "security_policy = mbd_bringup.ros.security_policy:main",
        "markers = mbd_bringup.ros.markers_node:main",
        "robots = mbd_bringup.ros.robot_sessions:main",
        "session = mbd_bringup.session_command:main",
    ],
)
