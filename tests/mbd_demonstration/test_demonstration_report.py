"""The report counts what is found, false and missed, and how far it is off."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.files.plateaus import acts, held_levels, held_stretches
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


def test_acts_are_found_without_anyone_having_named_them():
    assert [kind for kind, _ in acts(T, WIDTH)] == [kind for kind, _ in EVENTS]
    began_closed = T >= 4.0
    assert [kind for kind, _ in acts(T[began_closed], WIDTH[began_closed])] == ["open", "close", "open"]
    assert acts(T, np.full(T.size, 0.08)) == []


def test_while_a_thing_gives_way_any_date_from_the_end_of_the_fast_motion_on_is_right():
    soft = np.interp(T, [2, 3, 5, 9, 10], [0.08, 0.025, 0.015, 0.015, 0.08])
    close, opening = held_stretches(T, soft, acts(T, soft))
    assert (close.earliest, close.latest) == pytest.approx((3.0, 5.0), abs=0.4)
    assert close.off(4.0) == 0.0 and close.off(2.0) == pytest.approx(1.0, abs=0.4)
    assert opening.earliest == opening.latest == pytest.approx(9.0, abs=0.06)


def test_episodes_of_a_file_are_read_one_by_one_and_summed(tmp_path: Path):
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    n, path = T.size, tmp_path / "shown.parquet"
    states = np.concatenate([WIDTH, WIDTH])[:, None]
    table = {"timestamp": [*T, *T], "state": states.tolist(), "episode_index": [0] * n + [7] * n}
    parquet.write_table(pyarrow.table(table), path)
    lines = [line.split() for line in run([str(path)]).splitlines()[1:]]
    assert [line[:2] for line in lines] == [["shown", "0"], ["shown", "1"], ["all", "2"]]
    assert [line[3:6] for line in lines] == [["4", "0", "0"], ["4", "0", "0"], ["8", "0", "0"]]


def test_events_that_agree_are_neither_false_nor_missed(tmp_path: Path):
    words = run([str(folder_of(tmp_path, EVENTS))]).splitlines()[1].split()
    assert words[:5] == ["shown", "20.0", "4", "0", "0"] and float(words[6]) <= 0.05


def test_an_event_the_check_lacks_is_false_and_one_it_has_besides_is_missed(tmp_path: Path):
    words = run([str(folder_of(tmp_path, EVENTS[:2]))]).splitlines()[1].split()
    assert words[2:5] == ["4", "2", "0"]
    folder = folder_of(tmp_path, [("close", 2.5), ("open", 5.5), ("close", 8.5), ("open", 11.5), ("close", 13.5)])
    assert run([str(folder)]).splitlines()[1].split()[3:5] == ["0", "1"]


def test_a_path_without_recordings_is_named(tmp_path: Path):
    with pytest.raises(MbdError, match=str(tmp_path)):
        run([str(tmp_path)])
    with pytest.raises(MbdError, match="does not exist"):
        run([str(tmp_path / "none.csv")])
