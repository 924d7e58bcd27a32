"""Install mbd_study as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "replay = mbd_study.recompute.replay_command:main",
        "reevaluate = mbd_study.recompute.reevaluate_command:main",
        "bids = mbd_study.bids.bids_command:main",
        "analyse = mbd_study.analysis.analyse_command:main",
        "export = mbd_study.tables.export:main",
        "report = mbd_study.figures.report:main",
        "table = mbd_study.tables.session_table:main",
        "info = mbd_study.tables.info:main",
        "picture = mbd_study.figures.pictures:main",
        "plan = mbd_study.plan.plan_command:main",
        "share = mbd_study.sharing.share_command:main",
        "room_sync = mbd_study.room.room_sync_command:main",
        "room_device = mbd_study.ros.room_device:main",
        "elan = mbd_study.annotation.elan_command:main",
    ],
)
