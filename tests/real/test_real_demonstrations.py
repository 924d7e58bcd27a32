"""On real hand-guided recordings the finger opening gives the events their collector found."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.recording_files import RecordedColumns, read_recording
from mbd_demonstration.steps_command import run

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "demonstrations"
RECORDINGS = sorted(p.parent for p in FOLDER.glob("*/traj.csv"))
OPENING = FingerJointConfig(polarity=Polarity.LARGER_OPEN)  # the column's definition, not a setting of a file
TOLERANCE = 0.15  # [s]
pytestmark = [
    pytest.mark.skipif(
        not RECORDINGS, reason=f"{FOLDER} is absent: the real recordings are kept outside the repository"
    ),
    pytest.mark.parametrize("folder", RECORDINGS or [FOLDER], ids=lambda p: p.name),
]


def columns_of(folder: Path) -> RecordedColumns:
    return read_recording(folder / "traj.csv")


def assert_collectors(found: tuple[GripperEvent, ...], folder: Path, tolerance: float = TOLERANCE) -> None:
    expected = json.loads((folder / "meta.json").read_text())["gripper_events"]["events"]
    assert [e.action.name.lower() for e in found] == [e["type"] for e in expected]
    off = [abs(f.stamp - e["t_s"]) for f, e in zip(found, expected, strict=True)]
    assert max(off, default=0.0) <= tolerance


def test_events_of_a_real_recording_are_those_of_its_collector(folder: Path):
    columns = columns_of(folder)
    assert_collectors(read_gripper(columns.stamps, columns.gripper, OPENING).events, folder)


def test_they_stay_so_in_another_unit_of_the_other_polarity(folder: Path):
    columns = columns_of(folder)
    closing = FingerJointConfig(polarity=Polarity.LARGER_CLOSED)
    assert_collectors(read_gripper(columns.stamps, 255.0 - 3000.0 * columns.gripper, closing).events, folder)


@pytest.mark.parametrize("rate", [20.0, 50.0])
def test_they_stay_so_at_another_rate_with_samples_out_of_order(folder: Path, rate: float):
    columns = columns_of(folder)
    stamps = np.random.default_rng(0).permutation(np.arange(columns.stamps[0], columns.stamps[-1], 1.0 / rate))
    gripper = np.interp(stamps, columns.stamps, columns.gripper)
    assert_collectors(read_gripper(stamps, gripper, OPENING).events, folder, TOLERANCE + 1.0 / rate)


def test_the_steps_command_prints_them(folder: Path):
    lines = run([str(folder / "traj.csv")]).splitlines()
    expected = json.loads((folder / "meta.json").read_text())["gripper_events"]["events"]
    printed = [line.split() for line in lines if line.endswith(("open", "close"))]
    assert [action for *_, action in printed] == [e["type"] for e in expected]
    assert all(abs(float(at) - e["t_s"]) <= TOLERANCE for (at, *_), e in zip(printed, expected, strict=True))
