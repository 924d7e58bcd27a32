"""What was recorded is found again after any end of the process, also in the middle of a write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.journal import Journal, found
from mbd_demonstration.recording import Recording
from mbd_demonstration.synthetic import random_scene

SCENE = random_scene(np.random.default_rng(0), 2)


def recorded(n: int) -> Recording:
    recording = Recording(SCENE, 5.0)
    for k in range(n):
        recording.add_pose(0.1 * k, SCENE.frame_id, (float(k), 0.0, 1.0), (0.0, 0.0, 0.0, 1.0), 7.0 + k)
        recording.add_joints(0.1 * k, ["joint_1", "joint_finger_1"], [0.0, 0.5 * k], 7.0 + k)
    recording.add_event(GripperEvent(1.5, GripperAction.CLOSE))
    return recording


@given(parts=st.lists(st.integers(0, 30), min_size=1, max_size=5), cut=st.floats(0.0, 1.0))
def test_a_file_cut_off_anywhere_gives_what_was_written_before(tmp_path_factory, parts: list[int], cut: float):
    path: Path = tmp_path_factory.mktemp("journal") / "demonstration.recording"
    recording = Recording(SCENE, 5.0)
    journal = Journal.begin(path, recording, b"origin\n\x00", -1)
    ends = [path.stat().st_size]
    for part in parts:
        for _ in range(part):
            k = len(recording.poses)
            recording.add_pose(0.1 * k, SCENE.frame_id, (float(k), 0.0, 1.0), (0.0, 0.0, 0.0, 1.0), 7.0 + k)
        journal.append(recording)
        ends.append(path.stat().st_size)
    size = int(cut * ends[-1])
    path.write_bytes(path.read_bytes()[:size])
    again = found(path)
    if size < ends[0]:
        assert again is None
        return
    assert again is not None and again.origin == b"origin\n\x00" and again.begin == 5.0
    complete = sum(part for part, end in zip(parts, ends[1:], strict=True) if end <= size)
    there = again.into(Recording(SCENE, again.begin)).poses.table()
    np.testing.assert_array_equal(there, recording.poses.table()[:complete])


def test_poses_fingers_and_words_come_back_and_only_what_is_new_is_written(tmp_path: Path):
    path = tmp_path / "demonstration.recording"
    recording = recorded(10)
    journal = Journal.begin(path, recording, b"", 2)
    assert journal.append(recording) == 10 + 10 + 1
    assert journal.append(recording) == 0
    again = found(path)
    assert again is not None and again.again == 2
    back = again.into(Recording(SCENE, 5.0))
    assert back.events == recording.events
    np.testing.assert_array_equal(back.fingers["joint_finger_1"].table(), recording.fingers["joint_finger_1"].table())
    journal.end()
    assert found(path) is None


def test_a_file_of_something_else_is_no_recording(tmp_path: Path):
    path = tmp_path / "demonstration.recording"
    for content in (b"", b"\n", b"{}\n", b"\xff\xfe", b'{"version": 99, "begin": 0, "again": -1, "bytes": 0}\n'):
        path.write_bytes(content)
        assert found(path) is None
