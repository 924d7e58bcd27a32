"""Pictures as ada_ros2's ada_calibrate_camera keeps them: N_rgb_img.png beside N_sample.npz.

Its camera is on the hand and its board on the table; the archive holds gripper2base and the board's pose by its own
detection, which is not used here. Format: ada_calibrate_camera/camera_calibration.py of personalrobotics/ada_ros2.
"""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.taken import PictureFolder, TakenPicture
from mbd_robot.calibration.transforms import transform

SAMPLE = re.compile(r"(\d+)_sample\.npz")
TURN, PLACE = "R_gripper2base", "t_gripper2base"


def is_ada_folder(folder: Path) -> bool:
    """Whether it holds samples of ada_calibrate_camera."""
    return any(SAMPLE.fullmatch(file.name) for file in folder.glob("*_sample.npz"))


def read_ada_folder(folder: Path) -> PictureFolder:
    """What lies in such a folder; raises CalibrationError for a sample without its picture, or without a pose."""
    numbers = sorted(int(m[1]) for m in (SAMPLE.fullmatch(f.name) for f in folder.glob("*_sample.npz")) if m)
    pictures = []
    for number in numbers:
        sample, picture = folder / f"{number}_sample.npz", folder / f"{number}_rgb_img.png"
        if not picture.is_file():
            raise CalibrationError(f"{sample} has no picture: expected {picture.name} beside it")
        try:
            with np.load(sample, allow_pickle=False) as held:
                turn, place = np.asarray(held[TURN], float), np.asarray(held[PLACE], float)
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise CalibrationError(f"{sample} cannot be read ({error}); expected {TURN} and {PLACE}") from error
        if turn.size == 3:
            turn = Rotation.from_rotvec(turn.reshape(3)).as_matrix()
        if turn.shape != (3, 3) or place.size != 3:
            raise CalibrationError(f"{sample}: {TURN} is {turn.shape}, {PLACE} {place.shape}; expected (3, 3) and (3,)")
        pictures.append(TakenPicture(picture, transform(turn, place.reshape(3))))
    return PictureFolder(folder, pictures, mounting=BoardMounting.TABLE, base_frame="j2n6s200_link_base")
