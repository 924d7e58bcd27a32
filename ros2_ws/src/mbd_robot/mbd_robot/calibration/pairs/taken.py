"""Pictures and tool poses as they lie on disk, before anything is looked for in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.views import BoardCorners, find_corners
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.pairs.lens_estimate import estimated_lens
from mbd_robot.calibration.pairs.pair import BoardMounting, CalibrationPair, PairSet
from mbd_robot.calibration.transforms import Transforms


@dataclass(frozen=True)
class TakenPicture:
    """One picture and the pose of its moment.

    Attributes:
        file: the picture.
        tool: (4, 4) tool2base [m].
    """

    file: Path
    tool: Transforms

    @property
    def name(self) -> str:
        """For people."""
        return self.file.name

    def read(self) -> NDArray[np.uint8]:
        """(H, W) uint8 grey; raises CalibrationError when it is no picture."""
        pixels = cv2.imread(str(self.file), cv2.IMREAD_GRAYSCALE)
        if pixels is None:
            raise CalibrationError(f"{self.file} is no picture that can be read; expected PNG or JPEG")
        return np.asarray(pixels, dtype=np.uint8)


@dataclass(frozen=True)
class PictureFolder:
    """All of one calibration.

    Attributes:
        folder: where it lies.
        pictures: in the order they were taken.
        lens: that they were taken with; None where the folder does not say.
        mounting: which of camera and board moved; None where the folder does not say.
        board: that was seen; None where the folder does not say.
        base_frame: of the poses; "" where the folder does not say.
        camera_frame: the optical frame; "" where the folder does not say.
    """

    folder: Path
    pictures: Sequence[TakenPicture]
    lens: CalibratedLens | None = None
    mounting: BoardMounting | None = None
    board: BoardPattern | None = None
    base_frame: str = ""
    camera_frame: str = ""


def pairs_in(taken: PictureFolder, board: BoardPattern, mounting: BoardMounting) -> PairSet:
    """Find the board in every picture.

    Args:
        taken: pictures; without a lens it is estimated from these pictures themselves.
        board: to look for.
        mounting: which of camera and board moved.

    Raises:
        CalibrationError: a picture that cannot be read or is of another size, or no board in any.
    """
    found: list[tuple[TakenPicture, BoardCorners]] = []
    blind, sizes = [], {}
    for taken_picture in taken.pictures:
        picture = taken_picture.read()
        sizes[taken_picture.name] = (picture.shape[1], picture.shape[0])
        corners = find_corners(picture, board, None)
        if corners is None:
            blind.append(taken_picture.name)
        else:
            found.append((taken_picture, corners))
    if not found:
        raise CalibrationError(
            f"the board {board} is in none of the {len(taken.pictures)} pictures of {taken.folder}; expected "
            "COLUMNSxROWS:SQUARE:MARKER:DICTIONARY as it was printed (squares, not inner corners), sharp, and not "
            "mirrored; a board of an even number of rows by OpenCV before 4.6 needs ':legacy'"
        )
    lens = taken.lens or estimated_lens([c for _, c in found], board, sizes[found[0][0].name])
    wanted = (lens.pinhole.width, lens.pinhole.height)
    for name, size in sizes.items():
        if size != wanted:
            raise CalibrationError(
                f"{name} has {size[0]} x {size[1]} px, and the lens ({lens.origin}) is for {wanted[0]} x {wanted[1]}; "
                "expected the lens of these pictures"
            )
    pairs = [
        CalibrationPair(picture.name, picture.tool, replace(corners, pixels=lens.undistorted(corners.pixels)))
        for picture, corners in found
    ]
    return PairSet(mounting, board, lens, pairs, taken.base_frame, taken.camera_frame, tuple(blind))
