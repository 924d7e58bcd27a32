"""Whatever a recording of somebody else holds, reading it ends within bounds, in its numbers or in one sentence."""

from __future__ import annotations

import os
import signal
import sqlite3
import zipfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.files import bounded_reading
from mbd_demonstration.files.bounded_reading import read_bounded
from mbd_demonstration.files.recording_formats import read_any
from mbd_demonstration.recording_files import RecordingFileError, read_scene
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore


def too_much(path: Path) -> float:
    return float(np.ones(125_000_000).sum())  # 1 GB, written to


def without_end(path: Path) -> None:
    while True:
        pass


def crash(path: Path) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def hang(path: Path) -> None:
    signal.pause()


def name_and_size(path: Path, *, unit: int) -> tuple[str, float]:
    return path.name, path.stat().st_size / unit


@pytest.mark.parametrize(
    ("read", "words"),
    [(too_much, "took more than 256 MB"), (without_end, "more than 1 s"), (hang, "more than 1 s"), (crash, "crashed")],
)
def test_what_reads_too_much_too_long_or_crashes_is_one_sentence(
    read, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(bounded_reading, "SECONDS", 1)
    monkeypatch.setattr(bounded_reading, "BY_THE_CLOCK", 60 if read is without_end else 5)
    path = tmp_path / "recording.npz"
    path.write_bytes(b"x")
    with pytest.raises(RecordingFileError, match=words) as raised:
        read_bounded(read, path)
    assert str(path) in str(raised.value)


def test_what_a_reader_returns_comes_back_and_paths_may_be_relative(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a").write_bytes(b"1234")
    monkeypatch.chdir(tmp_path)
    assert read_bounded(name_and_size, Path("a"), unit=2) == ("a", 2.0)


def zip_bomb(path: Path) -> Path:
    header = b"\x93NUMPY\x01\x00v\x00" + b"{'descr': '<f8', 'fortran_order': False, 'shape': (50000000,), }".ljust(117)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("t.npy", "w") as stream:
        stream.write(header + b"\n")
        for _ in range(40):
            stream.write(bytes(10_000_000))
    return path


def endless_view(path: Path) -> Path:
    """A bag of sqlite3 whose messages are a question without an end."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        joints = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        bag.write(joints, 1, b"\0")
    with closing(sqlite3.connect(path / "bag.db3")) as database:
        database.executescript(
            "DROP TABLE messages;"
            "CREATE VIEW messages AS WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n)"
            " SELECT k AS id, 1 AS topic_id, k AS timestamp, x'00' AS data FROM n WHERE k < 0;"
        )
    return path


def nested(path: Path) -> Path:
    path.mkdir()
    (path / "metadata.yaml").write_text("[" * 200_000)
    return path


@pytest.mark.parametrize("make", [zip_bomb, endless_view, nested])
def test_a_hostile_recording_is_refused_in_one_sentence(make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bounded_reading, "SECONDS", 2)
    path = make(tmp_path / ("bag.npz" if make is zip_bomb else "bag"))
    with pytest.raises(RecordingFileError, match=r"cannot read") as raised:
        read_bounded(read_any, path)
    assert "\n" not in str(raised.value) and len(str(raised.value)) < 700


@pytest.mark.parametrize("text", ["[" * 100_000, "objects: [" + "{id: " * 50_000, "objects: [2020-99-99]"])
def test_a_hostile_scene_is_refused_in_one_sentence(text: str, tmp_path: Path):
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(RecordingFileError, match=r"scene\.yaml") as raised:
        read_bounded(read_scene, path)
    assert "\n" not in str(raised.value)
