"""The report counts what is found, false and missed, and how far it is off."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.files.plateaus import held_levels
from mbd_demonstration.files.report import run
from mbd_demonstration.recording_files import COLUMNS
from mbd_model.errors import MbdError

T = np.arange(0.0, 14.0, 0.05)
WIDTH = np.interp(T, [2, 3, 5, 6, 8, 9, 11, 12], [0.08, 0.02, 0.02, 0.08, 0.08, 0.05, 0.05, 0.08])
EVENTS = [("close", 2.5), ("open", 5.5), ("close", 8.5), ("open", 11.5)]


def folder_of(tmp_path: Path, events: list[tuple[str, float]]) -> Path:
    folder = tmp_path / "shown"
    folder.mkdir(exist_ok=True)
    rows = [f"{t},0.4,0,{0.3},1,0,0,0,{w}" for t, w in zip(T, WIDTH, strict=True)]
    (folder / "traj.csv").write_text("\n".join([",".join(COLUMNS), *rows]))
    listed = [{"type": kind, "t_s": at} for kind, at in events]
    (folder / "meta.json").write_text(json.dumps({"gripper_events": {"events": listed}}))
    return folder


def test_plateaus_are_where_the_width_arrives_and_leaves():
    found = held_levels(T, WIDTH, EVENTS)
    assert [at for _, at in found] == pytest.approx([3.0, 5.0, 9.0, 11.0], abs=0.06)


def test_events_that_agree_are_neither_false_nor_missed(tmp_path: Path):
    words = run([str(folder_of(tmp_path, EVENTS))]).splitlines()[1].split()
    assert words[:5] == ["shown", "20.0", "4", "0", "0"] and float(words[6]) <= 0.05


def test_an_event_the_check_lacks_is_false_and_one_it_has_besides_is_missed(tmp_path: Path):
    words = run([str(folder_of(tmp_path, EVENTS[:2]))]).splitlines()[1].split()
    assert words[2:5] == ["4", "2", "0"]
    folder = folder_of(tmp_path, [("close", 2.5), ("open", 5.5), ("close", 8.5), ("open", 11.5), ("close", 13.5)])
    assert run([str(folder)]).splitlines()[1].split()[3:5] == ["0", "1"]


def test_a_folder_without_recordings_is_named(tmp_path: Path):
    with pytest.raises(MbdError, match=r"no traj\.csv"):
        run([str(tmp_path)])
