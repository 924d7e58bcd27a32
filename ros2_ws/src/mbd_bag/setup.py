"""Install mbd_bag as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "recorder = mbd_bag.ros.recorder_node:main",
        "spool = mbd_bag.ros.spool_node:main",
        "second_spool = mbd_bag.ros.spool_node:second",
        "repair = mbd_bag.tools.repair:main",
        "repair_trials = mbd_bag.tools.repair_trials:main",
        "power_cuts = mbd_bag.tools.power_cuts:main",
        "mutation_trials = mbd_bag.tools.mutation_trials:main",
    ],
)
