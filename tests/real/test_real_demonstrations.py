"""On real hand-guided recordings the finger opening gives the events their collector found."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.finger_joint import FingerJointConfig, Polarity, read_gripper

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "demonstrations"
RECORDINGS = sorted(p.parent for p in FOLDER.glob("*/traj.csv"))
OPENING = FingerJointConfig(polarity=Polarity.LARGER_OPEN)  # the column's definition, not a setting of a file


@pytest.mark.skipif(not RECORDINGS, reason=f"{FOLDER} is absent: the real recordings are kept outside the repository")
@pytest.mark.parametrize("folder", RECORDINGS or [FOLDER], ids=lambda p: p.name)
def test_events_of_a_real_recording_are_those_of_its_collector(folder: Path):
    columns = np.genfromtxt(folder / "traj.csv", delimiter=",", names=True)
    expected = json.loads((folder / "meta.json").read_text())["gripper_events"]["events"]
    found = read_gripper(columns["t"], columns["gripper"], OPENING).events
    assert [e.action.name.lower() for e in found] == [e["type"] for e in expected]
    assert max(abs(f.stamp - e["t_s"]) for f, e in zip(found, expected, strict=True)) <= 0.15
