"""Install mbd_interaction as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "interaction = mbd_interaction.ros.node:main",
        "say = mbd_interaction.ros.say:main",
    ],
)
