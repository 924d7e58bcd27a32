"""A real session has no truth in it: what is right stands on a sheet that its experimenter fills in."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.superseded import supersede
from mbd_experiments.csv_table import read_csv, write_csv
from mbd_experiments.user_study import answers, experiment2
from mbd_experiments.user_study.answers import FILE_NAME, read_answers
from mbd_experiments.user_study.cases import case_of_session, read_cases
from mbd_experiments.user_study.consistency import assists_consistent, demonstration_consistent
from mbd_experiments.user_study.study_facts import Origin
from mbd_study.synthetic import SyntheticSession, session


def people(seed: int) -> SyntheticSession:
    """A session without truth, as with a real arm and real people."""
    made = session(f"p{seed}", np.random.default_rng(seed), num_assists=6)
    return replace(made, recorded=replace(made.recorded, truths=()))


def write(made: SyntheticSession, folder: Path) -> None:
    with BagWriter(folder / made.recorded.name) as bag:
        session_to_bag(made.recorded, bag)


@pytest.fixture
def study(tmp_path: Path) -> Path:
    for seed in range(2):
        write(people(seed), tmp_path)
    return tmp_path


def make_sheet(folder: Path) -> int:
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr(sys, "argv", ["answers", str(folder)])
        answers.main()
    return int(ended.value.code)


def fill_in(folder: Path) -> None:
    """As the experimenter would: what is right, and where each object was to be placed."""
    onto = {"s1": "s4", "s2": "s5", "s3": "s6"}
    right = {f"p{seed}": people(seed).solution for seed in range(2)}
    rows = read_csv(folder / FILE_NAME)
    for row in rows:
        row["right"] = " ".join(sorted(right[row["session"]][row["source"]]))
        row["placed_onto"] = onto.get(row["source"], "")
    write_csv(folder / FILE_NAME, rows)


def test_from_the_sheet_to_the_figures(study: Path, tmp_path: Path):
    assert make_sheet(study) == 0
    fill_in(study)
    cases, left_out = read_cases([study])
    assert left_out == ()
    assert [c.origin for c in cases] == [Origin.OWN] * 2
    assert all(demonstration_consistent(c) and assists_consistent(c) for c in cases)
    written = experiment2.run(cases, tmp_path / "out", ("mbd",))
    assert "figure9_own.png" in {p.name for p in written}
    page = (tmp_path / "out" / "experiment2.md").read_text()
    assert "Real data: sessions recorded with this project, 2 sessions." in page


def test_a_sheet_states_what_the_cells_truth_states(study: Path):
    make_sheet(study)
    fill_in(study)
    for seed, answer in enumerate(read_answers(study).values()):
        answered = case_of_session(people(seed).recorded, answer)
        known = case_of_session(session(f"p{seed}", np.random.default_rng(seed), num_assists=6).recorded)
        assert answered.acceptable == known.acceptable


def test_a_new_session_joins_the_sheet_and_what_was_filled_in_stays(study: Path):
    make_sheet(study)
    fill_in(study)
    before = read_csv(study / FILE_NAME)
    write(people(7), study)
    make_sheet(study)
    after = read_csv(study / FILE_NAME)
    assert after[: len(before)] == before
    assert {r["session"] for r in after[len(before) :]} == {"p7"}


def test_without_answers_each_bag_is_left_out_with_what_to_do(study: Path):
    with pytest.raises(BagError, match=r"no truth.*answers FOLDER"):
        read_cases([study])


def test_a_first_try_and_a_second_bag_of_one_session_are_not_counted(study: Path):
    make_sheet(study)
    fill_in(study)
    supersede(study / "p0")
    write(people(0), study)
    (study / "p1").rename(study / "copy_of_p1")
    write(people(1), study)
    cases, left_out = read_cases([study])
    assert [c.name for c in cases] == ["p0", "p1"]
    assert [(entry.path.name, entry.reason) for entry in left_out] == [("p1", "another bag holds session 'p1' already")]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"right": "t99"}, "target object 't99' in session 'p0', which has t1"),
        ({"source": "s99"}, "source object 's99'"),
        ({"placed_onto": "s98"}, "source object 's98'"),
        ({"right": ""}, "does not state what is right for 's1'"),
    ],
)
def test_an_answer_that_cannot_be_is_named(change: dict[str, str], words: str, study: Path):
    make_sheet(study)
    fill_in(study)
    rows = read_csv(study / FILE_NAME)
    rows[0].update(change)
    write_csv(study / FILE_NAME, rows)
    cases, left_out = read_cases([study])
    assert [c.name for c in cases] == ["p1"]
    assert words in left_out[0].reason


def test_an_object_answered_twice_is_refused(study: Path):
    make_sheet(study)
    rows = read_csv(study / FILE_NAME)
    write_csv(study / FILE_NAME, [*rows, rows[0]])
    with pytest.raises(BagError, match="answered twice"):
        read_answers(study)


@given(data=st.binary(max_size=200))
def test_a_sheet_of_anything_is_read_or_refused(data: bytes, tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("sheet")
    (folder / FILE_NAME).write_bytes(data)
    try:
        read_answers(folder)
    except BagError:
        return


SHEET = 'session,source,looks,right,placed_onto\nstacking,s1,"cup, hue 30",t2,s5\nstacking,s5,"cup, hue 0",t1,\n'


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_a_sheet_saved_by_a_spreadsheet_is_read(tmp_path: Path, ends: str, encoding: str):
    """With a byte-order mark, with any line ends, and with the empty rows a spreadsheet leaves behind."""
    (tmp_path / FILE_NAME).write_bytes((SHEET + ",,,,\n").replace("\n", ends).encode(encoding))
    answer = read_answers(tmp_path)["stacking"]
    assert dict(answer.right) == {"s1": frozenset({"t2"}), "s5": frozenset({"t1"})}
    assert answer.script == (("s1", "s5"),)


@pytest.mark.parametrize(("sign", "reason"), [(";", "semicolons"), ("\t", "tabs")])
def test_a_sheet_of_other_separators_is_refused_for_that(tmp_path: Path, sign: str, reason: str):
    """The reason says what separates the columns, not that columns are missing."""
    text = SHEET.replace('"cup, hue 30"', "cup").replace('"cup, hue 0"', "cup").replace(",", sign)
    (tmp_path / FILE_NAME).write_bytes(text.encode("utf-8-sig"))
    with pytest.raises(BagError, match=reason):
        read_answers(tmp_path)


def test_a_sheet_without_a_column_is_refused_by_its_name(tmp_path: Path):
    (tmp_path / FILE_NAME).write_text(SHEET.replace("source", "from", 1))
    with pytest.raises(BagError, match="'source' is missing"):
        read_answers(tmp_path)


def test_the_recorded_case_of_a_spreadsheet_is_read(shared_data: Path, tmp_path: Path):
    """The file with a byte-order mark and CRLF that a spreadsheet wrote."""
    (tmp_path / FILE_NAME).write_bytes((shared_data / "cases" / "mapping" / "answers_excel_utf8_bom.csv").read_bytes())
    assert read_answers(tmp_path)["stacking"].right["s2"] == frozenset({"t4"})
