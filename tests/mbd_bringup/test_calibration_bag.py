"""Pictures for a calibration out of a bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from board_scene import BOARD, LENS
from calibration_messages import image, pictured, pose_stamped
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_bringup.ros.calibration_bag import main
from mbd_model.ros.conversions import header
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.profiles.camera import COLOR, INFO
from mbd_robot.topics import TOOL_POSE
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo


def write_bag(folder: Path) -> list[np.ndarray]:
    """A hand that rests twice before the camera; returns its two poses."""
    down = Rotation.from_euler("x", np.pi)
    tools = []
    with BagWriter(folder) as bag:
        messages = MessageWriter(bag)
        for k, turn in enumerate(([0.0, 0.2, 0.0], [0.25, 0.0, 0.1])):
            tool = np.eye(4)
            tool[:3, :3], tool[:3, 3] = (Rotation.from_rotvec(turn) * down).as_matrix(), (0.58, 0.0, 0.35)
            board = np.eye(4)
            board[:3, 3] = (-0.12, -0.1, 0.0)
            picture = pictured(tool @ board)
            tools.append(tool)
            for i in range(12):
                stamp = 10.0 * (k + 1) + 0.1 * i
                info = CameraInfo(
                    header=header(stamp, "optical"), width=LENS.pinhole.width, height=LENS.pinhole.height,
                    k=LENS.matrix.reshape(-1), distortion_model="plumb_bob",
                )  # fmt: skip
                at = int(stamp * 1e9)
                messages.write(INFO, info, at)
                messages.write(TOOL_POSE, pose_stamped(tool, stamp), at)
                messages.write(COLOR, image(picture, "bgr8", stamp), at)
    return tools


def test_a_picture_comes_of_every_rest_in_the_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tools = write_bag(tmp_path / "bag")
    words = [str(tmp_path / "bag"), "--out", str(tmp_path / "calib"), "--board", str(BOARD)]
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0, capsys.readouterr().err
    held = read_pictures(tmp_path / "calib")
    for picture, tool in zip(held.pictures, tools, strict=True):
        assert np.abs(picture.tool - tool).max() < 1e-4


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [("--color", "front/image", "the bag has no front/image; it has"), ("--board", str(PrintedBoard()), "nowhere in")],
)
def test_what_the_bag_lacks_is_said(
    tmp_path: Path, option: str, value: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_bag(tmp_path / "bag")
    with pytest.raises(SystemExit) as ended:
        main([str(tmp_path / "bag"), "--out", str(tmp_path / "calib"), "--board", str(BOARD), option, value])
    assert ended.value.code == 2
    assert said in " ".join(capsys.readouterr().err.split())
