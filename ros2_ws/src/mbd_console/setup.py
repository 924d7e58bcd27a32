"""Install mbd_console as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "console = mbd_console.ros.main:main",
    ],
    package_data=["static/*", "words/*.yaml"],
)
