"""Install mbd_demonstration as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "demonstration = mbd_demonstration.ros.node:main",
        "steps = mbd_demonstration.steps_command:main",
        "demonstration_report = mbd_demonstration.files.report:main",
    ],
)
