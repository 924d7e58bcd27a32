"""Install mbd_robot as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "robot = mbd_robot.ros.robot_node:main",
        "camera = mbd_robot.ros.camera_node:main",
        "profile = mbd_robot.profile_command:main",
        "calibrate = mbd_robot.calibration.command:main",
    ],
    package_data=["models/*.xml"],
)
