"""A folder of pictures, whoever wrote it."""

from __future__ import annotations

from pathlib import Path

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.ada_folder import is_ada_folder, read_ada_folder
from mbd_robot.calibration.pairs.own_folder import is_own_folder, read_own_folder
from mbd_robot.calibration.pairs.taken import PictureFolder


def read_pictures(folder: Path) -> PictureFolder:
    """What lies in a folder of ours or of ada_ros2's; raises CalibrationError when it is neither."""
    if not folder.is_dir():
        raise CalibrationError(f"there is no folder {folder}; expected one of pictures and {'poses.csv'}")
    if not is_own_folder(folder) and is_ada_folder(folder):
        return read_ada_folder(folder)
    return read_own_folder(folder)
