"""What a calibration reads and writes: boards, folders, lenses, camera files; what is wrong with one is said."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.errors import MbdError
from mbd_robot.calibration.board.april_grid import AprilGrid
from mbd_robot.calibration.board.chessboard import Chessboard
from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.printed import DICTIONARIES, PrintedBoard
from mbd_robot.calibration.board.printing import print_board
from mbd_robot.calibration.board.views import find_corners
from mbd_robot.calibration.camera_file import pose_matrix, read_camera_file, write_camera_file
from mbd_robot.calibration.command import main
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens, read_lens
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.calibration.pairs.stillness import StillnessWatch
from mbd_robot.calibration.pairs.writing import PictureWriter
from mbd_robot.calibration.touching.touches import read_touches
from mbd_robot.calibration.transforms import Transforms, exponential

TWISTS = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(lambda v: exponential(np.array(v)))
LENS = CalibratedLens(Intrinsics(600.0, 601.0, 319.5, 239.5, width=640, height=480), (0.1, -0.2, 0.001, 0.0, 0.03))
GREY = np.full((480, 640), 128, np.uint8)


@given(st.integers(3, 9), st.integers(3, 9), st.floats(5.0, 90.0), st.sampled_from(DICTIONARIES), st.booleans())
@settings(max_examples=20)
def test_a_board_is_read_as_it_is_written(
    columns: int, rows: int, square: float, dictionary: str, legacy: bool
) -> None:
    board = PrintedBoard(columns, rows, round(square, 2), round(square * 0.7, 2), dictionary, legacy)
    assert board_of(str(board)) == board
    assert len(board.corners) == (columns - 1) * (rows - 1)


@given(st.integers(4, 12), st.integers(4, 12), st.integers(5, 90), st.integers(1, 9))
@settings(max_examples=20)
def test_other_boards_are_read_as_they_are_written(columns: int, rows: int, side: int, part: int) -> None:
    grid = AprilGrid(columns, rows, float(side), side * part / 10.0)
    assert board_of(str(grid)) == grid
    if (columns + rows) % 2:
        board = Chessboard(columns, rows, side / 2.0)
        assert board_of(str(board)) == board


@pytest.mark.parametrize(
    "board", [Chessboard(8, 5, 30.0), Chessboard(5, 8, 22.5), AprilGrid(4, 3, 40.0, 12.0)], ids=str
)
@pytest.mark.parametrize("quarters", range(4))
def test_a_print_is_found_at_its_true_size_however_it_is_turned(
    board: BoardPattern, quarters: int, tmp_path: Path
) -> None:
    print_board(board, tmp_path / "board.png")
    upright = np.asarray(cv2.imread(str(tmp_path / "board.png"), cv2.IMREAD_GRAYSCALE))
    small = cv2.resize(upright, None, fx=0.2, fy=0.2, interpolation=cv2.INTER_AREA)
    corners = find_corners(np.ascontiguousarray(np.rot90(small, quarters), dtype=np.uint8), board, None)
    assert corners is not None and len(corners.numbers) == len(board.corners)
    found, wanted = corners.pixels, board.corners[corners.numbers, :2] * 1000.0
    found, wanted = found - found.mean(axis=0), wanted - wanted.mean(axis=0)
    c, s = ((1, 0), (0, -1), (-1, 0), (0, 1))[quarters]
    turned = wanted @ np.array([[c, s], [-s, c]], dtype=float)
    assert found * 25.4 / (300.0 * 0.2) == pytest.approx(turned, abs=0.1)


def test_the_print_is_the_board_that_is_looked_for_at_its_true_size(tmp_path: Path) -> None:
    board = PrintedBoard(7, 6, 30.0, 21.5, "5X5_100", legacy=True)
    assert "Print on A4" in print_board(board, tmp_path / "board.png")
    picture = cv2.imread(str(tmp_path / "board.png"), cv2.IMREAD_GRAYSCALE)
    corners = find_corners(np.asarray(picture, dtype=np.uint8), board, None)
    assert corners is not None and len(corners.numbers) == len(board.corners)
    # 300 pixels an inch: a square is 30 mm.
    apart = np.linalg.norm(corners.pixels[1] - corners.pixels[0]) * 25.4 / 300.0
    assert apart == pytest.approx(30.0, abs=0.03)
    with pytest.raises(MbdError, match="nothing is overwritten"):
        print_board(board, tmp_path / "board.png")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("8x6", "expected COLUMNSxROWS:SQUARE:MARKER:DICTIONARY"),
        ("8x6:25:30:5X5_100", "markers smaller than their squares"),
        ("8x6:25:18:5X5_10", "did you mean 5X5_100"),
        ("14x9:18.8:13.8:5X5_50", "need 63 markers, and 5X5_50 has 50"),
        ("2x2:25:18:5X5_100", "3 to 40 each way"),
        ("chessboard:9x6", "expected chessboard:COLUMNSxROWS:SQUARE"),
        ("chessboard:9x7:25", "looks the same after half a turn"),
        ("aprilgrid:6x6:80", "such as aprilgrid:6x6:30:9"),
        ("aprilgrid:6x6:80:90", "gaps smaller than tags"),
        ("aprilgrid:30x30:8:2", "2 to 587 tags"),
    ],
)
def test_a_board_that_cannot_be_is_refused(text: str, said: str) -> None:
    with pytest.raises(CalibrationError, match=said):
        board_of(text)


@given(TWISTS)
@settings(max_examples=20)
def test_a_camera_file_holds_the_pose_that_was_written(
    tmp_path_factory: pytest.TempPathFactory, pose: Transforms
) -> None:
    file = tmp_path_factory.mktemp("camera") / "camera.yaml"
    notes = ["a word with: a colon, and a very long one " + "mm " * 60]
    write_camera_file(file, pose, ("base", ""), notes, datetime(2026, 1, 1, tzinfo=UTC))
    assert np.abs(pose_matrix(read_camera_file(file)) - pose).max() < 1e-5
    assert max(map(len, file.read_text().splitlines())) <= 120
    before = file.read_text()
    with pytest.raises(MbdError, match="nothing is overwritten"):
        write_camera_file(file, np.eye(4), ("", ""), [], datetime(2026, 1, 1, tzinfo=UTC))
    assert file.read_text() == before


@pytest.mark.parametrize("text", ["", "- 1", "a: 1", "/**: {ros__parameters: {camera_position: [1, 2, 3]}}", "{"])
def test_a_file_that_is_no_camera_file_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "camera.yaml").write_text(text)
    with pytest.raises(MbdError, match="no camera file"):
        read_camera_file(tmp_path / "camera.yaml")


@given(st.lists(TWISTS, min_size=1, max_size=4))
@settings(max_examples=8)
def test_a_folder_is_read_as_it_was_taken(tmp_path_factory: pytest.TempPathFactory, tools: list[Transforms]) -> None:
    folder = tmp_path_factory.mktemp("taken") / "new"
    writer = PictureWriter(folder, PrintedBoard(), BoardMounting.TABLE, ("base", "optical"), LENS)
    for tool in tools:
        writer.add(GREY, tool, joints={"j1": 0.5})
    held = read_pictures(folder)
    assert held.mounting is BoardMounting.TABLE and held.board == PrintedBoard()
    assert (held.base_frame, held.camera_frame) == ("base", "optical")
    assert held.lens is not None and held.lens.pinhole == LENS.pinhole and held.lens.distortion == LENS.distortion
    for picture, tool in zip(held.pictures, tools, strict=True):
        assert np.abs(picture.tool - tool).max() < 1e-5
        assert picture.read().shape == GREY.shape
    with pytest.raises(MbdError, match="not empty"):
        PictureWriter(folder, PrintedBoard(), BoardMounting.TABLE, ("", ""), LENS)


@pytest.mark.parametrize(
    ("poses", "said"),
    [
        ("picture,x,y,z,qx,qy,qz,qw\na.png,1,2,3,0,0,0,zero\n", r"line 2: qw is 'zero'"),
        ("picture,x,y,z,qx,qy,qz,qw\na.png,1,2,3,0,0,0,9\n", r"line 2: the quaternion has length 9.00"),
        ("picture,x,y,z\na.png,1,2,3\n", r"line 2: no 'qx'"),
        ("picture,x,y,z,qx,qy,qz,qw\nb.png,1,2,3,0,0,0,1\n", r"line 2: there is no picture"),
        ("picture,x,y,z,qx,qy,qz,qw\na.png,nan,2,3,0,0,0,1\n", r"not finite"),
        ("picture,x,y,z,qx,qy,qz,qw\n", r"names no picture"),
    ],
)
def test_a_bad_pose_is_refused_with_its_line(tmp_path: Path, poses: str, said: str) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), GREY)
    (tmp_path / "poses.csv").write_text(poses)
    with pytest.raises(CalibrationError, match=said):
        read_pictures(tmp_path)


def test_rotation_vectors_and_yaml_say_the_same_as_quaternions(tmp_path: Path) -> None:
    turns = {"csv": "picture,x,y,z,rx,ry,rz\na.png,1,2,3,0,0,1.5707963\n"}
    entry = {"picture": "a.png", "position": [1, 2, 3], "orientation": [0, 0, 0.70710678, 0.70710678]}
    turns["yaml"] = yaml.safe_dump([entry])
    read = []
    for ending, text in turns.items():
        folder = tmp_path / ending
        folder.mkdir()
        cv2.imwrite(str(folder / "a.png"), GREY)
        (folder / f"poses.{ending}").write_text(text)
        read.append(read_pictures(folder).pictures[0].tool)
    assert np.abs(read[0] - read[1]).max() < 1e-6


def test_samples_of_ada_are_read(tmp_path: Path) -> None:
    tool = exponential(np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))
    for number in (0, 2, 10):
        cv2.imwrite(str(tmp_path / f"{number}_rgb_img.png"), GREY)
        np.savez_compressed(
            tmp_path / f"{number}_sample.npz", R_gripper2base=tool[:3, :3], t_gripper2base=tool[:3, 3]
        )  # fmt: skip
    held = read_pictures(tmp_path)
    assert [p.name for p in held.pictures] == [f"{n}_rgb_img.png" for n in (0, 2, 10)]
    assert held.mounting is BoardMounting.TABLE and np.abs(held.pictures[1].tool - tool).max() < 1e-9
    (tmp_path / "10_sample.npz").write_bytes(b"no archive")
    with pytest.raises(CalibrationError, match="R_gripper2base and t_gripper2base"):
        read_pictures(tmp_path)


@pytest.mark.parametrize(
    ("text", "said"),
    [("a: 1", "lacks"), ("[1]", "no keys"), ("{", "cannot be read"),
     ("{width: 640, height: 480, k: [1, 2], d: []}", "2 numbers; expected 9"),
     ("{width: 640, height: 480, k: [1,0,1,0,1,1,0,0,1], d: [1,1,1,1], distortion_model: equidistant}", "equidistant")],
)  # fmt: skip
def test_a_lens_that_is_none_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "lens.yaml").write_text(text)
    with pytest.raises(CalibrationError, match=said):
        read_lens(tmp_path / "lens.yaml")


def test_the_tip_that_touches_is_beyond_the_tool_along_its_fingers(tmp_path: Path) -> None:
    file = tmp_path / "touched.csv"
    file.write_text("corner,x,y,z,qx,qy,qz,qw\ntop_left,0.5,0,0.1,1,0,0,0\n3,0.5,0,0.1,0,0.70710678,0,0.70710678\n")
    down, forward = read_touches(file, PrintedBoard(), 0.02)
    assert down.place == pytest.approx([0.5, 0.0, 0.08]) and forward.place == pytest.approx([0.52, 0.0, 0.1])
    file.write_text("corner,x,y,z\nmiddle,0,0,0\n")
    with pytest.raises(CalibrationError, match="line 2: corner 'middle'"):
        read_touches(file, PrintedBoard(), 0.02)


def test_the_hand_rests_only_when_it_stays(tmp_path: Path) -> None:
    watch, rng = StillnessWatch(rest=0.5), np.random.default_rng(1)
    for k in range(20):  # on its way
        watch.pose(k * 0.1, exponential(np.array([0.0, 0.0, 0.0, 0.01 * k, 0.0, 0.0])))
        assert watch.resting() is None
    there = exponential(np.array([0.1, 0.0, 0.0, 0.3, 0.0, 0.0]))
    for k in range(20, 30):
        watch.pose(k * 0.1, there @ exponential(rng.normal(0.0, 1e-4, 6)))
    resting = watch.resting()
    assert resting is not None and resting.since == pytest.approx(2.0)
    assert np.abs(resting.tool - there).max() < 5e-4 and watch.is_new(resting.tool)
    watch.took(resting.tool)
    assert not watch.is_new(there) and watch.is_new(there @ exponential(np.array([0.2, 0, 0, 0, 0, 0.0])))
    watch.pose(0.0, there)  # a clock that was set back
    assert watch.resting() is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("solve", "nowhere"), "there is no folder nowhere"),
        (("board", "--out", "board.doc"), "expected .pdf, .png, .svg"),
        (("check", "nowhere", "--pose", "none.yaml", "--out", "c.png"), "none.yaml cannot be read"),
    ],
)
def test_a_command_that_cannot_be_done_says_so_in_one_line(
    words: tuple[str, ...],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 1
    written = capsys.readouterr().err
    assert said in written and written.count("\n") == 1 and not list(tmp_path.iterdir())
