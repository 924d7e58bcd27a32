"""`calibrate` on pictures rendered before the cell's camera, with its noise: commands as a person types them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from board_scene import BOARD, CAMERA, LENS, BoardScene
from mbd_robot.calibration.board.april_grid import AprilGrid
from mbd_robot.calibration.board.chessboard import Chessboard
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.views import find_corners
from mbd_robot.calibration.camera_file import pose_matrix, read_camera_file
from mbd_robot.calibration.command import main
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.writing import PictureWriter
from mbd_robot.calibration.transforms import Transforms, exponential, transform
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.profiles.find import robot_profile
from scipy.spatial.transform import Rotation

# Where the board is in the hand: beside the fingers, its face up when they point down.
IN_HAND = transform(Rotation.from_euler("xz", (0.1, 0.3)).as_matrix(), (-0.14, -0.05, -0.02))
DOWN = Rotation.from_euler("x", np.pi)
ARM_ERROR = 0.001  # [m, rad] of a tool's pose, standard deviation


@pytest.fixture(scope="module")
def scene() -> Iterator[BoardScene]:
    with BoardScene() as made:
        yield made


def poses(rng: np.random.Generator, count: int) -> Iterator[Transforms]:
    """Of the tool, over the table, with the board before the camera."""
    for _ in range(count):
        turn = Rotation.from_rotvec(rng.normal(0.0, 0.3, 3)) * DOWN
        yield transform(turn.as_matrix(), np.array((0.58, 0.0, 0.35)) + rng.normal(0.0, (0.06, 0.08, 0.05)))


def take_pictures(scene: BoardScene, board: BoardPattern, folder: Path, count: int) -> Path:
    """Pictures of the board on a Jaco's hand; joints that put the arm there, as far as drawing goes."""
    rng = np.random.default_rng(8)
    profile = robot_profile("jaco2")
    joints = dict(zip(profile.arm.joints, profile.arm.ready, strict=True))
    writer = PictureWriter(folder, board, BoardMounting.HAND, ("base", "camera_color_optical_frame"), LENS)
    for tool in poses(rng, count):
        color, depth = scene.picture(tool @ IN_HAND, rng)
        if find_corners(color, board, LENS) is not None:
            told = tool @ exponential(rng.normal(0.0, ARM_ERROR, 6))
            writer.add(color, told, depth, joints)
    assert writer.count >= 0.7 * count
    return folder


@pytest.fixture(scope="module")
def hand_folder(scene: BoardScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return take_pictures(scene, BOARD, tmp_path_factory.mktemp("calibration") / "hand", 14)


@pytest.fixture(scope="module")
def camera_file(hand_folder: Path) -> Path:
    file = hand_folder.parent / "camera.yaml"
    assert run("solve", str(hand_folder), "--out", str(file)) == 0
    return file


def run(*words: str) -> int:
    """A command's exit code."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    return int(ended.value.code or 0)


def test_the_camera_is_found_within_what_is_stated(
    camera_file: Path, hand_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("solve", str(hand_folder)) == 0
    said = capsys.readouterr().out
    stated = re.search(r"put within ([\d.]+) mm of where it is", said)
    assert stated is not None, said
    found = pose_matrix(read_camera_file(camera_file))
    point = np.array([0.0, 0.0, 1.0, 1.0])
    off = float(np.linalg.norm((found - CAMERA) @ point)) * 1000.0
    assert off < float(stated.group(1)) < 10.0
    assert "refined" in said and "left out" not in said


@pytest.mark.parametrize("board", [Chessboard(7, 6, 36.0), AprilGrid(4, 3, 44.0, 13.2)], ids=str)
def test_boards_of_other_kinds_find_the_camera_as_well(
    board: BoardPattern, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with BoardScene(board) as scene:
        folder = take_pictures(scene, board, tmp_path / "hand", 10)
    assert run("solve", str(folder), "--out", str(tmp_path / "camera.yaml")) == 0
    stated = re.search(r"put within ([\d.]+) mm of where it is", capsys.readouterr().out)
    assert stated is not None
    found = pose_matrix(read_camera_file(tmp_path / "camera.yaml"))
    off = float(np.linalg.norm((found - CAMERA) @ (0.0, 0.0, 1.0, 1.0))) * 1000.0
    assert off < float(stated.group(1)) < 12.0


def test_a_session_s_nodes_take_the_file_as_it_is(camera_file: Path) -> None:
    from mbd_console.parameters import CONSOLE
    from mbd_perception.parameters import PERCEPTION

    held = yaml.safe_load(camera_file.read_text())["/**"]["ros__parameters"]
    for table in (PERCEPTION, CONSOLE):
        assert list(table.values(held)["camera_position"]) == pytest.approx(held["camera_position"])


def test_nothing_is_written_twice(
    camera_file: Path, hand_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    before = camera_file.read_text()
    assert run("solve", str(hand_folder), "--out", str(camera_file)) == 1
    assert "nothing is overwritten" in capsys.readouterr().err
    assert camera_file.read_text() == before


def test_the_check_says_how_far_off_table_and_hand_are(
    camera_file: Path, hand_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "check.png"
    words = ("check", str(hand_folder), "--pose", str(camera_file), "--robot", "jaco2")
    assert run(*words, "--out", str(picture)) == 0
    said = capsys.readouterr().out
    table, hand = (re.search(p, said) for p in (r"at the table: seen ([\d.]+) mm", r"is seen ([\d.]+) mm"))
    assert table is not None and hand is not None, said
    assert float(table.group(1)) < 4.0 and float(hand.group(1)) < 8.0
    assert "the arm: drawn" in said
    drawn, taken = cv2.imread(str(picture)), cv2.imread(str(sorted(hand_folder.glob("0??.png"))[-1]))
    assert drawn is not None and taken is not None and drawn.shape == taken.shape
    assert (drawn != taken).any(axis=2).mean() > 0.01


def test_the_check_tells_a_camera_that_was_pushed(
    camera_file: Path, hand_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pushed = tmp_path / "pushed.yaml"
    held = yaml.safe_load(camera_file.read_text())
    held["/**"]["ros__parameters"]["camera_position"][2] += 0.02
    pushed.write_text(yaml.safe_dump(held))
    (tmp_path / "pushed.board.yaml").write_text(camera_file.with_suffix(".board.yaml").read_text())
    assert run("check", str(hand_folder), "--pose", str(pushed), "--out", str(tmp_path / "c.png")) == 0
    said = capsys.readouterr().out
    table, hand = (re.search(p, said) for p in (r"at the table: seen ([\d.]+) mm above", r"is seen ([\d.]+) mm"))
    assert table is not None and hand is not None, said
    assert 16.0 < float(table.group(1)) < 24.0 and 15.0 < float(hand.group(1)) < 26.0


def test_touched_corners_of_a_board_on_the_table_give_the_camera_too(
    scene: BoardScene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(5)
    lying = transform((Rotation.from_euler("z", 0.4) * DOWN).as_matrix(), (0.5, 0.1, 0.003))
    color, _ = scene.picture(lying, rng)
    cv2.imwrite(str(tmp_path / "board.png"), np.ascontiguousarray(color[..., ::-1]))
    lines = ["corner,x,y,z"]
    names = ("top_left", "top_right", "bottom_right", "bottom_left", "7", "12")
    for name, point in zip(names, [*BOARD.outline, BOARD.corners[7], BOARD.corners[12]], strict=True):
        x, y, z = lying[:3, :3] @ point + lying[:3, 3] + rng.normal(0.0, 0.0005, 3)
        lines.append(f"{name},{x:.5f},{y:.5f},{z + 0.014:.5f}")  # the tool's point is above its tip
    (tmp_path / "touched.csv").write_text("\n".join(lines))
    matrix = [float(v) for v in LENS.matrix.reshape(-1)]
    lens = {"image_width": 640, "image_height": 480, "camera_matrix": {"data": matrix}}
    (tmp_path / "lens.yaml").write_text(yaml.safe_dump(lens))
    files = {k: str(tmp_path / v) for k, v in (("touched", "touched.csv"), ("lens", "lens.yaml"), ("out", "c.yaml"))}
    options = [w for name, file in files.items() for w in (f"--{name}", file)]
    assert run("touch", str(tmp_path / "board.png"), "--board", str(BOARD), *options) == 0
    stated = re.search(r"looks is put within ([\d.]+) mm", capsys.readouterr().out)
    assert stated is not None
    found = pose_matrix(read_camera_file(tmp_path / "c.yaml"))
    assert float(np.linalg.norm((found - CAMERA) @ (0.0, 0.0, 1.0, 1.0))) * 1000.0 < 2 * float(stated.group(1)) < 15.0


def test_the_drawn_arm_is_where_the_joints_put_it() -> None:
    from mbd_robot.calibration.check.arm_shapes import arm_shapes

    profile = robot_profile("jaco2")
    chain = ArmChain(profile, table_height=None)
    joints = dict(zip(profile.arm.joints, profile.arm.ready, strict=True))
    shapes = arm_shapes(chain, joints)
    tool = chain.tool_pose(np.array(profile.arm.ready)).position
    points = np.concatenate(shapes)
    assert len(shapes) > 4
    assert np.linalg.norm(points - tool, axis=1).min() < 0.15
