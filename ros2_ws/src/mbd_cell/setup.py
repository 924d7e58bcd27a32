"""Install mbd_cell as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "cell = mbd_cell.ros.cell_node:main",
        "wizard = mbd_cell.ros.wizard_node:main",
    ],
)
