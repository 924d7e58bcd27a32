"""The camera's pose by pictures of the board and their tool poses, with its error; writes the session's file."""

from __future__ import annotations

import argparse
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
from mbd_model.errors import MbdError

from mbd_robot.calibration.camera_file import write_camera_file
from mbd_robot.calibration.commands.options import add_folder, add_table_height, mounting_of, taken_pictures
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.hand_board import write_hand_board
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.taken import PictureFolder, pairs_in
from mbd_robot.calibration.report import left_out_statement, report, statement
from mbd_robot.calibration.solving.calibration import HandEyeCalibration, calibrate
from mbd_robot.calibration.transforms import Transforms

SEED = 1


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    add_folder(parser)
    parser.add_argument("--out", type=Path, help="camera file to write, for camera_file:= of a session")
    add_table_height(parser)
    parser.add_argument(
        "--look-from", metavar="PICTURE",
        help="with the camera on the hand: the picture whose pose the hand takes whenever the table is looked at",
    )  # fmt: skip
    parser.add_argument("--anyway", action="store_true", help="give also a pose that alike poses leave open")


def run(given: argparse.Namespace) -> int:
    """Solve, report, write; raises MbdError when any of it cannot be done."""
    if given.out and given.out.exists():
        raise MbdError(f"{given.out} is there already, and nothing is overwritten; give another name")
    taken, board = taken_pictures(given)
    mounting = mounting_of(given, taken)
    if given.look_from and mounting is BoardMounting.HAND:
        raise CalibrationError("--look-from is for a camera on the hand, and this one stands (--mounting hand)")
    pairs = pairs_in(taken, board, mounting)
    result = calibrate(pairs, np.random.default_rng(SEED), given.table_height, allow_open=given.anyway)
    sys.stdout.write("\n".join(report(result)) + "\n")
    if mounting is BoardMounting.TABLE:
        sys.stdout.write(_static_transform(result) + "\n")
    if given.out:
        _write(given, taken, result)
        sys.stdout.write(f"written: {given.out}\n")
    return 0


def _write(given: argparse.Namespace, taken: PictureFolder, result: HandEyeCalibration) -> None:
    notes = [statement(result), f"Left out and foretold: {left_out_statement(result)}", f"From {taken.folder.name}."]
    pose = result.fit.x
    if result.mounting is BoardMounting.TABLE:
        pose = _looked_from(given, taken) @ pose
        notes.append(f"The camera is on the hand: this holds while the hand is where it was for {given.look_from}.")
    frames = (result.problem.given.base_frame, result.problem.given.camera_frame)
    write_camera_file(given.out, pose, frames, notes, datetime.now())
    if result.mounting is BoardMounting.HAND:
        write_hand_board(given.out, result.problem.given.board, result.fit.y)


def _looked_from(given: argparse.Namespace, taken: PictureFolder) -> Transforms:
    """The tool pose of the picture that is named."""
    names = [picture.name for picture in taken.pictures]
    if given.look_from not in names:
        asked = f"there is no picture '{given.look_from}'" if given.look_from else "the camera is on the hand"
        raise CalibrationError(
            f"{asked}: name with --look-from the picture whose pose the hand takes whenever the table is looked at, "
            f"one of {', '.join(names[:6])}, ...; or use the static transform above with camera_pose:=tf of perception"
        )
    return taken.pictures[names.index(given.look_from)].tool


def _static_transform(result: HandEyeCalibration) -> str:
    x, y, z = result.fit.x[:3, 3]
    qx, qy, qz, qw = result.quaternion
    child = result.problem.given.camera_frame or "OPTICAL_FRAME"
    return (
        "as a static transform of the frame that the poses are of: ros2 run tf2_ros static_transform_publisher "
        f"--x {x:.5f} --y {y:.5f} --z {z:.5f} --qx {qx:.6f} --qy {qy:.6f} --qz {qz:.6f} --qw {qw:.6f} "
        f"--frame-id TOOL_FRAME --child-frame-id {child}"
    )
