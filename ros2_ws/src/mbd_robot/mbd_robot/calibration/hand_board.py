"""Where a board is on the hand, kept beside the camera file, so that a later check can tell how far off the hand is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import yaml
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.camera_file import write_new
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.transforms import Transforms, from_quaternion

ENDING = ".board.yaml"


@dataclass(frozen=True)
class HandBoard:
    """A board on the hand.

    Attributes:
        board: the print.
        pose: (4, 4) board2tool [m].
    """

    board: BoardPattern
    pose: Transforms


def hand_board_file(camera_file: Path) -> Path:
    """Where it is kept."""
    return camera_file.with_suffix(ENDING)


def write_hand_board(camera_file: Path, board: BoardPattern, pose: Transforms) -> None:
    """Keep it beside a camera file; raises MbdError when there is such a file already."""
    held = {
        "board": str(board),
        "position": [float(v) for v in pose[:3, 3]],
        "orientation": [float(v) for v in Rotation.from_matrix(pose[:3, :3]).as_quat()],
    }
    heading = (
        "# The board on the hand: its top left corner in the tool's frame; m and (x, y, z, w). For `calibrate check`.\n"
    )
    write_new(hand_board_file(camera_file), heading + yaml.safe_dump(held, sort_keys=False))


def read_hand_board(camera_file: Path) -> HandBoard | None:
    """What is kept beside a camera file; None for nothing, CalibrationError for a file that cannot be used."""
    file = hand_board_file(camera_file)
    if not file.exists():
        return None
    try:
        held = yaml.safe_load(file.read_text(encoding="utf-8"))
        return HandBoard(board_of(str(held["board"])), from_quaternion(held["position"], held["orientation"]))
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise CalibrationError(f"{file} cannot be used ({error}); expected what `calibrate solve` writes") from error
