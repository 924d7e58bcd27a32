"""`calibrate take` beside a robot and a camera that run, and `check` on the picture it took: the cell plays both."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from ament_index_python.packages import get_package_share_directory
from board_scene import BOARD, CAMERA, LENS
from cell_and_robot import LIMIT, Playground, playground
from mbd_robot.calibration.check.arm_shapes import arm_shapes
from mbd_robot.calibration.check.drawing import ARM
from mbd_robot.calibration.command import main
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.calibration.pairs.writing import JOINTS
from mbd_robot.calibration.transforms import inverse
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.profiles.find import robot_profile
from mbd_robot.ros.calibration.picture_collector import PictureTaking
from mbd_robot.ros.calibration.picture_taking import CalibrationPictures
from numpy.typing import NDArray

AT_ONCE = 12  # callbacks of what one slice of the cell's time publishes
OVER_ALL = 0.3  # [m] above the table there is nothing but the arm


def live(there: Playground, true: Callable[[], bool]) -> None:
    """Let time pass no faster than what the cell publishes is taken: three processes share this one's executor."""
    end = time.monotonic() + LIMIT
    while not true():
        assert time.monotonic() < end, "no picture was taken"
        assert there.cell is not None
        there.cell.advance()
        for _ in range(AT_ONCE):
            there.executor.spin_once(timeout_sec=0.003)


@pytest.fixture
def taken(ros_domain: int, tmp_path: Path) -> Iterator[Path]:
    """A picture of the arm at rest, with its joints, as the command's node takes it."""
    folder = tmp_path / "calib"
    with playground(ros_domain) as there:
        there.start_cell("jaco2")
        there.start_robot("jaco2")
        there.until(lambda: len(there.received) == 2)
        assert there.move(0.5, 0.15, 0.3).success
        taking = PictureTaking(folder, BOARD, BoardMounting.HAND, 1, board_needed=False)
        pictures = there.add(CalibrationPictures(taking, lambda _: None, context=there.context))
        live(there, lambda: pictures.collector.done)
    yield folder


def heights(depth: NDArray[np.uint16]) -> NDArray[np.float64]:
    """(H, W) height of what each pixel shows over the base's z = 0 [m]; 0 where nothing is seen."""
    v, u = np.indices(depth.shape)
    z = depth / 1000.0
    rays = np.stack(
        [(u - LENS.pinhole.cx) / LENS.pinhole.fx, (v - LENS.pinhole.cy) / LENS.pinhole.fy, np.ones(u.shape)]
    )
    points = np.tensordot(CAMERA[:3, :3], rays * z, axes=1)
    return np.where(z > 0, points[2] + CAMERA[2, 3], 0.0)


def silhouettes(joints: dict[str, float]) -> NDArray[np.bool_]:
    """(H, W) where the arm's shapes are in the picture."""
    to_camera, mask = inverse(CAMERA), np.zeros((LENS.pinhole.height, LENS.pinhole.width), np.uint8)
    for points in arm_shapes(ArmChain(robot_profile("jaco2"), table_height=None), joints):
        seen = points @ to_camera[:3, :3].T + to_camera[:3, 3]
        if seen[:, 2].min() > 0.02:
            cv2.fillConvexPoly(mask, cv2.convexHull(np.rint(LENS.project(seen)).astype(np.int32)), 1)
    return mask > 0


def test_the_arm_is_drawn_where_the_picture_shows_it(taken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = taken.parent / "check.png"
    pose = Path(get_package_share_directory("mbd_cell"), "config", "camera.yaml")
    with pytest.raises(SystemExit) as ended:
        main(["check", str(taken), "--pose", str(pose), "--robot", "jaco2", "--out", str(file)])
    said = capsys.readouterr().out
    assert ended.value.code == 0 and "the arm: drawn" in said, said
    picture = read_pictures(taken).pictures[0]
    depth = cv2.imread(str(next(taken.glob("*depth*.png"))), cv2.IMREAD_UNCHANGED)
    plain, drawn = cv2.imread(str(picture.file)), cv2.imread(str(file))
    assert plain is not None and drawn is not None and depth is not None
    arm = silhouettes(yaml.safe_load((taken / JOINTS).read_text())[picture.name])
    lines = (np.abs(drawn.astype(int) - ARM[::-1]).max(axis=2) < 30) & (drawn != plain).any(axis=2)
    near = cv2.dilate(arm.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert lines.sum() > 500 and near[lines].mean() > 0.99
    height = heights(np.asarray(depth, np.uint16))
    high = height > OVER_ALL
    assert high.sum() > 2000
    assert arm[high].mean() > 0.9
    assert (height[arm & (depth > 0)] > 0.03).mean() > 0.8
