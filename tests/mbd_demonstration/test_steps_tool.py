"""The steps tool prints what a recording shows, and states of a bad file what is wrong with it."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.finger_joint import Polarity
from mbd_demonstration.recording_files import COLUMNS
from mbd_demonstration.steps_command import run
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene
from mbd_model.errors import MbdError


@pytest.fixture(scope="module")
def shown() -> Demonstration:
    scene = random_scene(np.random.default_rng(5), 4)
    moves = (Move("s1", onto="s2"), Move("s3", onto="s1"))
    recorder = Sensing(polarity=Polarity.LARGER_OPEN, travel=0.08)
    return demonstrate(scene, moves, recorder, np.random.default_rng(5))


@pytest.fixture
def files(shown: Demonstration, tmp_path: Path) -> tuple[str, str]:
    """(recording, scene) as files."""
    recording, scene = tmp_path / "traj.csv", tmp_path / "scene.yaml"
    with recording.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(COLUMNS)
        for t, p, (qx, qy, qz, qw), g in zip(
            shown.stamps, shown.positions, shown.quaternions, shown.joint, strict=True
        ):
            writer.writerow([t, *p, qw, qx, qy, qz, g])
    lines = [
        f"  - {{id: {o.object_id}, centroid: {list(o.centroid)}, size: {list(o.size)}, yaw: {o.yaw}}}"
        for o in shown.scene.objects
    ]
    scene.write_text("\n".join(["objects:", *lines]))
    return str(recording), str(scene)


def test_the_steps_are_printed_in_order_with_their_objects(files: tuple[str, str], shown: Demonstration):
    lines = run([files[0], "--scene", files[1]]).splitlines()
    assert lines[0] == "4 steps"
    assert [tuple(line.split()[2:4]) for line in lines[2:6]] == [(kind.name, i) for kind, i in shown.steps]


def test_without_a_scene_the_gripper_events_are_printed(files: tuple[str, str], shown: Demonstration):
    lines = run([files[0]]).splitlines()
    assert [line.split()[-1] for line in lines[1:]] == [e.action.name.lower() for e in shown.events]


def test_the_wrong_polarity_does_not_go_unnoticed(files: tuple[str, str]):
    output = run([files[0], "--scene", files[1], "--polarity", "larger_closed"])
    assert "note: at" in output and "4 steps" not in output


def rows(*lines: str) -> str:
    return "\n".join([",".join(COLUMNS), *lines]) + "\n"


def rewrite(recording: str, change: Callable[[list[list[str]]], list[list[str]]]) -> None:
    """Change the rows of a recording below its first line."""
    with Path(recording).open(newline="") as stream:
        first, *body = csv.reader(stream)
    with Path(recording).open("w", newline="") as stream:
        csv.writer(stream).writerows([first, *change(body)])


def test_the_order_of_rows_does_not_matter_and_is_not_mended_in_silence(files: tuple[str, str]):
    before = run([files[0], "--scene", files[1]]).splitlines()
    rewrite(files[0], lambda body: body[::-1])
    *lines, note = run([files[0], "--scene", files[1]]).splitlines()
    assert lines == before
    assert "not in order of time" in note and "sorted by their stamps" in note


def test_lost_cells_are_counted_and_the_steps_stay(files: tuple[str, str]):
    before = run([files[0], "--scene", files[1]]).splitlines()
    rewrite(files[0], lambda body: [[*row[:-1], ""] if k % 50 == 9 else row for k, row in enumerate(body)])
    *lines, note = run([files[0], "--scene", files[1]]).splitlines()
    assert len(lines) == len(before) and [x.split()[2:4] for x in lines] == [x.split()[2:4] for x in before]
    assert note.startswith("note: ") and "rows lack a number" in note


def test_each_step_has_its_runner_up_and_the_margin_to_it(files: tuple[str, str], shown: Demonstration):
    for line in run([files[0], "--scene", files[1]]).splitlines()[2:6]:
        *_, at, runner_up, margin = line.split()
        assert runner_up in shown.scene.ids
        assert float(at) >= 0.0 and float(margin) > 0.0


def test_two_finger_columns_are_read_as_one_gripper(files: tuple[str, str]):
    before = run([files[0], "--scene", files[1]])
    text = Path(files[0]).read_text().splitlines()
    split = [text[0].replace("gripper", "left, right")]
    split += [f"{line},{float(line.rsplit(',', 1)[1]) + 0.5}" for line in text[1:]]
    Path(files[0]).write_text("\n".join(split))
    assert run([files[0], "--scene", files[1], "--fingers", "left", "right"]) == before


def test_known_levels_of_a_hand_may_be_given(files: tuple[str, str]):
    learned = run([files[0]]).splitlines()
    levels = ["--open-level", "0.08", "--closed-level", "0.0"]
    given = run([files[0], *levels]).splitlines()
    assert [line.split()[-1] for line in given] == [line.split()[-1] for line in learned]
    with pytest.raises(MbdError, match="give both"):
        run([files[0], *levels[:2]])


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("", "lacks the columns"),
        ("t,x,y\n0,0,0\n", "lacks the columns ['z'"),
        (",".join(COLUMNS) + "\n", "has no rows"),
        (",".join(COLUMNS) + "\n0,0,0,0,1,0,0,0,wide\n", "line 2: could not convert string to float: 'wide'"),
        (rows("0,0,0,0,1,0,0,0,1", "0,0,0,0,1,0,0,0,0"), "1 different times in column t"),
        (rows("0,0,0,0,1,0,0,0,", "1,0,0,0,1,0,0,0,nan"), "no number in the gripper's columns"),
        (rows("0,0,0,0,1,0,0,0,1", "33,0,0,0,1,0,0,0,0"), "samples are 33 apart in column t; it must hold seconds"),
        (rows(*(f"{2 * k},0,0,0,1,0,0,0,{k // 1500}" for k in range(3000))), "are these milliseconds?"),
        ("gripper," + rows("1,0,0,0,0,1,0,0,0,1"), "has the columns ['gripper'] more than once"),
        (rows("0,450,0,9,1,0,0,0,1", "1,450,0,9,1,0,0,0,0"), "450 from the robot's base; x, y and z must be in metres"),
        (rows("0,0,0,0,0,3,0,1,1", "1,0,0,0,0,3,0,1,0"), "have length 3.16; a quaternion's is 1"),
        (rows("0,nan,0,0,1,0,0,0,1", "1,nan,0,0,1,0,0,0,0"), "no row with numbers for x, y and z"),
    ],
)
def test_a_bad_recording_is_named_with_what_is_wrong(tmp_path: Path, content: str, why: str):
    (tmp_path / "traj.csv").write_text(content)
    with pytest.raises(MbdError) as error:
        run([str(tmp_path / "traj.csv")])
    assert why in str(error.value) and "traj.csv" in str(error.value)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("objects: []", "at least one object"),
        ("objects: [{id: a}]", "object 1: expected id, centroid"),
        ("objects: [{id: a, centroid: [0, 0], size: [1, 1, 1]}]", "object 1"),
        ("objects: [{id: a, centroid: [0, 0, 0], size: [1, 1, 0]}]", "three positive numbers"),
        (
            "objects: [{id: a, centroid: [0, 0, 0], size: [1, 1, 1]}, {id: a, centroid: [1, 0, 0], size: [1, 1, 1]}]",
            "ids",
        ),
        ("objects: [{id: a, centroid: [.nan, 0, 0], size: [1, 1, 1]}]", "object 1"),
        ("objects: [{id: a, centroid: [450, 100, 50], size: [60, 60, 100]}]", "give metres"),
        ("{", "cannot read"),
    ],
)
def test_a_bad_scene_is_named_with_what_is_wrong(files: tuple[str, str], content: str, why: str):
    Path(files[1]).write_text(content)
    with pytest.raises(MbdError) as error:
        run([files[0], "--scene", files[1]])
    assert why in str(error.value)


def test_a_missing_file_is_named(tmp_path: Path):
    with pytest.raises(MbdError, match=r"nowhere\.csv"):
        run([str(tmp_path / "nowhere.csv")])


def test_arrays_without_a_value_are_named(tmp_path: Path):
    np.savez(tmp_path / "empty.npz", **{name: np.zeros(0) for name in COLUMNS})
    with pytest.raises(MbdError, match="nothing was recorded"):
        run([str(tmp_path / "empty.npz")])


def test_another_episode_of_a_file_that_holds_one_is_refused(files: tuple[str, str]):
    with pytest.raises(MbdError, match="--episode is 3"):
        run([files[0], "--episode", "3"])


@pytest.mark.parametrize("picture", ["nowhere/p.png", "p.xyz"])
def test_a_picture_that_cannot_be_written_is_named(files: tuple[str, str], tmp_path: Path, picture: str):
    with pytest.raises(MbdError, match="cannot draw into") as error:
        run([files[0], "--plot", str(tmp_path / picture)])
    assert "\n" not in str(error.value)


def test_without_a_scene_slow_sampling_is_said_too(files: tuple[str, str]):
    rewrite(files[0], lambda body: body[::40])
    assert any("was sampled every" in line for line in run([files[0]]).splitlines())
