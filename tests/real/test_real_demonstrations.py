"""On real hand-guided recordings every event is dated when the hand holds or lets go, whatever rate, unit and sign."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.files.plateaus import held_levels
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper
from mbd_demonstration.gripper import GripperAction, GripperEvent
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


def collectors(folder: Path) -> list[tuple[str, float]]:
    """The collector's own events: which there are is right, when is by a share of the range and only roughly so."""
    found = json.loads((folder / "meta.json").read_text())["gripper_events"]["events"]
    return [(e["type"], e["t_s"]) for e in found]


def assert_plateaus(found: tuple[GripperEvent, ...], folder: Path, tolerance: float = TOLERANCE) -> None:
    columns = columns_of(folder)
    expected = held_levels(columns.stamps, columns.gripper, collectors(folder))
    assert [e.action.name.lower() for e in found] == [kind for kind, _ in expected]
    off = [abs(f.stamp - at) for f, (_, at) in zip(found, expected, strict=True)]
    assert max(off, default=0.0) <= tolerance


def test_events_of_a_real_recording_are_dated_at_the_plateaus_of_its_width(folder: Path):
    columns = columns_of(folder)
    assert_plateaus(read_gripper(columns.stamps, columns.gripper, OPENING).events, folder)


@pytest.mark.parametrize("levels", [(0.08, 0.0), (0.04, 0.03), (5.0, -1.0)])
def test_levels_given_never_make_it_worse(folder: Path, levels: tuple[float, float]):
    columns = columns_of(folder)
    config = FingerJointConfig(open_level=levels[0], closed_level=levels[1])
    assert_plateaus(read_gripper(columns.stamps, columns.gripper, config).events, folder)


@pytest.mark.parametrize("unit", [-3000.0, 255.0, 100.0, -1.0, -17.45])
def test_they_stay_so_in_another_unit_and_of_the_other_polarity(folder: Path, unit: float):
    columns = columns_of(folder)
    config = FingerJointConfig(polarity=Polarity.LARGER_OPEN if unit > 0 else Polarity.LARGER_CLOSED)
    assert_plateaus(read_gripper(columns.stamps, 255.0 + unit * columns.gripper, config).events, folder)


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 200.0, 1000.0])
def test_they_stay_so_at_another_rate_with_samples_out_of_order(folder: Path, rate: float):
    columns = columns_of(folder)
    stamps = np.random.default_rng(0).permutation(np.arange(columns.stamps[0], columns.stamps[-1], 1.0 / rate))
    gripper = np.interp(stamps, columns.stamps, columns.gripper)
    assert_plateaus(read_gripper(stamps, gripper, OPENING).events, folder, max(TOLERANCE, 1.5 / rate))


@pytest.mark.parametrize("rate", [1, 2])
@pytest.mark.parametrize("rounded", [0.0, 0.001])
def test_they_stay_so_at_a_low_rate_wherever_the_first_sample_lies(folder: Path, rate: int, rounded: float):
    columns = columns_of(folder)
    step = round(1.0 / (rate * float(np.median(np.diff(columns.stamps)))))
    width = np.round(columns.gripper / rounded) * rounded if rounded else columns.gripper
    for first in range(step):
        events = read_gripper(columns.stamps[first::step], width[first::step], OPENING).events
        assert_plateaus(events, folder, 1.5 / rate)


def test_the_steps_command_prints_them(folder: Path):
    lines = run([str(folder / "traj.csv")]).splitlines()
    printed = [line.split() for line in lines if line.endswith(("open", "close"))]
    actions = {"open": GripperAction.OPEN, "close": GripperAction.CLOSE}
    assert_plateaus(tuple(GripperEvent(float(at), actions[action]) for at, _, action in printed), folder)
