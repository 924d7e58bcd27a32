"""Table, tool and arm drawn into a picture where a camera file says they are, and how far off that is, in words."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import cv2
import numpy as np
import yaml
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_robot.calibration.board.views import find_corners, view_of
from mbd_robot.calibration.camera_file import pose_matrix, read_camera_file
from mbd_robot.calibration.check.drawing import BOARD, PictureDrawing
from mbd_robot.calibration.check.table import TableArea, table_seen
from mbd_robot.calibration.commands.options import add_folder, add_table_height, taken_pictures
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.hand_board import HandBoard, read_hand_board
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.pairs.taken import PictureFolder, TakenPicture
from mbd_robot.calibration.pairs.writing import DEPTH, JOINTS
from mbd_robot.calibration.transforms import Transforms, inverse
from mbd_robot.profiles.find import robot_profile

GOOD = 0.005  # [m] of error that the suite's motions bear without a thought
AXIS = 0.08  # [m] of a drawn frame


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    add_folder(parser)
    parser.add_argument("--pose", type=Path, required=True, help="the camera file that is checked")
    parser.add_argument("--picture", help="of the folder (default: the last)")
    parser.add_argument("--robot", help="name or file of its profile: draws the arm, where the folder has its joints")
    parser.add_argument(
        "--area", type=float, nargs=4, metavar=("X0", "X1", "Y0", "Y1"), default=(0.25, 1.3, -0.7, 0.7),
        help="[m] the part of the table worked on, base frame (default: that of jaco2_workspace.yaml)",
    )  # fmt: skip
    add_table_height(parser)
    parser.add_argument("--out", type=Path, required=True, help="picture to write: .png or .jpg")


def run(given: argparse.Namespace) -> int:
    """Draw and measure; exit code 1 only for what cannot be used: a bad pose is for a person to judge."""
    if given.out.exists():
        raise MbdError(f"{given.out} is there already, and nothing is overwritten; give another name")
    pose = pose_matrix(read_camera_file(given.pose))
    taken, _ = taken_pictures(given)
    if taken.lens is None:
        raise CalibrationError(
            f"{taken.folder} has no lens.yaml; give --lens, a camera_info or camera_calibration's file"
        )
    picture = _chosen(taken, given.picture)
    x0, x1, y0, y1 = given.area
    area = TableArea((x0, x1), (y0, y1), given.table_height)
    pixels = _undistorted(picture.file, taken.lens)
    drawing = PictureDrawing(pixels, taken.lens, pose)
    drawing.table(area)
    drawing.frame(np.eye(4), 2 * AXIS, "base")
    drawing.frame(picture.tool, AXIS, "tool")
    lines = [_table_words(picture.file, taken.lens, pose, area)]
    lines.append(_hand_words(drawing, picture, taken.lens, pose, read_hand_board(given.pose)))
    if given.robot:
        lines.append(_arm_words(drawing, picture, given.robot))
    drawing.legend([_short(line) for line in lines])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(given.out), np.ascontiguousarray(drawing.picture[..., ::-1])):
        raise MbdError(f"{given.out} cannot be written; expected a name ending in .png or .jpg, in a place of yours")
    lines.append(
        f"drawn in {given.out}: the yellow grid must lie on the table (10 cm a cell), the frame 'tool' between the "
        "fingertips, blue along them"
    )
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


def _short(line: str) -> str:
    """What of a line fits into a picture."""
    return re.split(r" \(|: that|, no |, [+-]", line, maxsplit=1)[0][:80]


def _chosen(taken: PictureFolder, name: str | None) -> TakenPicture:
    if name is None:
        return taken.pictures[-1]
    for picture in taken.pictures:
        if picture.name == name:
            return picture
    raise CalibrationError(
        f"{taken.folder} has no picture '{name}'; it has {', '.join(p.name for p in taken.pictures)}"
    )


def _undistorted(file: Path, lens: CalibratedLens) -> NDArray[np.uint8]:
    """(H, W, 3) RGB as a lens without distortion would show it."""
    pixels = cv2.imread(str(file), cv2.IMREAD_COLOR)
    if pixels is None:
        raise CalibrationError(f"{file} is no picture that can be read; expected PNG or JPEG")
    size = (pixels.shape[1], pixels.shape[0])
    if size != (lens.pinhole.width, lens.pinhole.height):
        raise CalibrationError(
            f"{file.name} has {size[0]} x {size[1]} px, and the lens is for {lens.pinhole.width} x "
            f"{lens.pinhole.height}; expected the lens of this picture"
        )
    if lens.distortion:
        pixels = cv2.undistort(pixels, lens.matrix, np.array(lens.distortion))
    return np.ascontiguousarray(pixels[..., ::-1], dtype=np.uint8)


def _table_words(file: Path, lens: CalibratedLens, pose: Transforms, area: TableArea) -> str:
    depth_file = file.with_name(file.stem + DEPTH)
    if not depth_file.exists():
        return f"at the table: not measured, no depth image {depth_file.name} beside the picture"
    depth = cv2.imread(str(depth_file), cv2.IMREAD_UNCHANGED)
    if depth is None or depth.dtype != np.uint16 or depth.shape != (lens.pinhole.height, lens.pinhole.width):
        raise CalibrationError(f"{depth_file} is no depth image of 16 bit [mm] as large as its picture")
    try:
        seen = table_seen(np.asarray(depth, dtype=np.float32) / 1000.0, lens, pose, area)
    except CalibrationError as error:
        return f"at the table: {error}"
    middle, worst = (v * 1000.0 for v in seen.errors(area.height))
    judged = "well enough" if abs(worst) < GOOD * 1000.0 else "look at the camera's pose, the table's height and level"
    return (
        f"at the table: seen {abs(middle):.1f} mm {'above' if middle > 0 else 'below'} z = {area.height:g} m in its "
        f"middle, {worst:+.1f} mm at its worst corner, tilted by {seen.tilt:.2f} deg: that is {judged}"
    )


def _hand_words(
    drawing: PictureDrawing, picture: TakenPicture, lens: CalibratedLens, pose: Transforms, held: HandBoard | None
) -> str:
    """How far the board on the hand is from where tool pose and camera file say that it is."""
    if held is None:
        return "at the hand: not measured, no board's place is kept beside the camera file; compare the drawn tool"
    flat = CalibratedLens(lens.pinhole)
    corners = find_corners(_undistorted(picture.file, lens), held.board, flat)
    view = view_of(corners, held.board, flat) if corners else None
    expected = inverse(pose) @ picture.tool @ held.pose
    in_base = pose @ expected
    outline = held.board.outline @ in_base[:3, :3].T + in_base[:3, 3]
    if corners is None or view is None:
        return "at the hand: not measured, the board is not seen in this picture; take one with it on the hand"
    drawing.line(np.vstack((outline, outline[:1])), BOARD, 2)
    there = expected[:3, :3] @ held.board.centre + expected[:3, 3]
    here = view.pose[:3, :3] @ held.board.centre + view.pose[:3, 3]
    points = held.board.corners[corners.numbers] @ expected[:3, :3].T + expected[:3, 3]
    off = np.linalg.norm(flat.project(points) - corners.pixels, axis=1)
    x, y, z = (pose[:3, :3] @ (here - there)) * 1000.0
    return (
        f"at the hand: the board is seen {np.linalg.norm(here - there) * 1000.0:.1f} mm ({x:+.1f}, {y:+.1f}, {z:+.1f} "
        f"along the base's x, y, z) from where the tool's pose puts it, {off.mean():.1f} px"
    )


def _arm_words(drawing: PictureDrawing, picture: TakenPicture, robot: str) -> str:
    file = picture.file.with_name(JOINTS)
    try:
        joints = (yaml.safe_load(file.read_text(encoding="utf-8")) or {}).get(picture.name)
    except (OSError, yaml.YAMLError) as error:
        return f"the arm: not drawn, {file} cannot be read: {error}"
    if not joints:
        return f"the arm: not drawn, {file.name} has no joints for {picture.name}"
    try:
        from mbd_robot.calibration.check.arm_shapes import arm_shapes
        from mbd_robot.kinematics.chain import ArmChain
    except ImportError as error:
        return f"the arm: not drawn, {error.name} is not installed: pip install -r requirements/sim.txt"
    chain = ArmChain(robot_profile(robot), table_height=None)
    for shape in arm_shapes(chain, joints):
        drawing.outline(shape)
    tool = chain.tool_pose(np.array([joints[name] for name in chain.profile.arm.joints])).position
    apart = float(np.linalg.norm(tool - picture.tool[:3, 3])) * 1000.0
    return f"the arm: drawn by its joints, whose tool is {apart:.1f} mm from the tool's pose"
