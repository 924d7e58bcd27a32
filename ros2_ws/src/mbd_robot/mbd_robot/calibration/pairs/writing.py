"""A folder of pictures that grows while they are taken: each is on disk before the next."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import yaml
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.camera_file import write_new
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.pairs.own_folder import ABOUT, COLUMNS, LENS, POSES_CSV, pose_line
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.transforms import Transforms

DEPTH = "_depth.png"  # [mm], uint16, beside the picture of that name
JOINTS = "joints.yaml"


class PictureWriter:
    """Writes pictures and poses.

    Args:
        folder: new, or empty.
        board: that is looked for.
        mounting: where it is.
        frames: (base frame, optical frame).
        lens: of the camera.

    Raises:
        MbdError: the folder holds something already, or cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        board: BoardPattern,
        mounting: BoardMounting,
        frames: tuple[str, str],
        lens: CalibratedLens,
    ) -> None:
        refuse_used(folder)
        self.folder, self.count = folder, 0
        about = {"board": str(board), "mounting": mounting.value, "base_frame": frames[0], "camera_frame": frames[1]}
        write_new(folder / ABOUT, yaml.safe_dump(about, sort_keys=False))
        p = lens.pinhole
        held = {
            "image_width": p.width,
            "image_height": p.height,
            "camera_matrix": {"rows": 3, "cols": 3, "data": [float(v) for v in lens.matrix.reshape(-1)]},
            "distortion_model": "rational_polynomial" if len(lens.distortion) > 5 else "plumb_bob",
            "distortion_coefficients": {"rows": 1, "cols": len(lens.distortion), "data": list(lens.distortion)},
        }
        write_new(folder / LENS, yaml.safe_dump(held, sort_keys=False))
        write_new(folder / POSES_CSV, ",".join(COLUMNS) + "\n")

    def add(
        self,
        picture: NDArray[np.uint8],
        tool: Transforms,
        depth: NDArray[np.float32] | None = None,
        joints: dict[str, float] | None = None,
    ) -> str:
        """Write one; returns its name.

        Args:
            picture: (H, W) grey or (H, W, 3) RGB.
            tool: (4, 4) tool2base.
            depth: (H, W) [m], NaN or 0 where nothing returned.
            joints: position [rad] by name.
        """
        name = f"{self.count:03d}.png"
        shown = picture if picture.ndim == 2 else picture[..., ::-1]
        self._write(name, np.ascontiguousarray(shown))
        if depth is not None:
            millimetres = np.clip(np.nan_to_num(depth) * 1000.0, 0, 65535).round().astype(np.uint16)
            self._write(f"{self.count:03d}{DEPTH}", millimetres)
        if joints:
            with (self.folder / JOINTS).open("a", encoding="utf-8") as out:
                out.write(yaml.safe_dump({name: joints}, default_flow_style=None, sort_keys=False))
        with (self.folder / POSES_CSV).open("a", encoding="utf-8") as out:
            out.write(pose_line(name, tool))
        self.count += 1
        return name

    def _write(self, name: str, pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
        if not cv2.imwrite(str(self.folder / name), pixels):
            raise MbdError(f"{self.folder / name} cannot be written; is the disk full?")


def refuse_used(folder: Path) -> None:
    """Raises MbdError for a folder that holds something, or cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise MbdError(f"{folder} is not empty, and nothing is overwritten; give a new folder")
    except OSError as error:
        raise MbdError(f"{folder} cannot be used: {error.strerror}; give another place") from error
