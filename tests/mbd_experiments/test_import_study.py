"""A study folder becomes session bags."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_experiments.public_study.study_folder import StudyFolderError, read_study
from mbd_experiments.user_study.import_study import STUDY_CONFIG, import_study, recorded_session
from mbd_experiments.user_study.study_facts import Origin, script_from
from mbd_study.recompute.reevaluation import reevaluate
from mbd_study.tables.correctness import answers_of

FILES = {
    "u3_t2/source_objects.txt": "milk,1.0,0.2,0.7,6,6,11,210,{},{}\nbox,1.1,0.0,0.7,25,18,6,-1000,{},{}\n",
    "u3_t2/target_objects.txt": "juice,1.0,0.2,0.7,6,6,12,30,{},{}\nbox,1.1,0.0,0.7,23,17,5,330,{},{}\n",
    "u3_t2/targeters.txt": "(milk)+0.1,(milk)+1,(milk)+3e+111\n(box)+0.1,(box)+1,(box)+1\n(milk)+1,(milk)+1,(milk)\n",
    "u3_t2/hints.txt": "juice\nbox\n",
    "knowledge/lunch.txt": "affordances;milk:pourable;juice:pourable;box:fillable\nproperties;milk:;juice:;box:open\n",
    "solutions/t2.txt": "milk:juice\nbox:box\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        path = tmp_path / "study" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "study"


def test_an_imported_bag_holds_what_the_folder_holds(folder: Path, tmp_path: Path):
    (path,) = import_study(folder, tmp_path / "bags")
    session = session_from_bag(Bag(path))
    (read,) = read_study(folder)
    assert session == recorded_session(read)
    assert session.target_scenes[0].value.objects == read.target.objects
    assert [a.target_id for a in session.assists[-1].value] == ["juice", "box"]
    assert [e.value.num_assists for e, _ in session.estimates] == [0, 1, 2]
    assert Bag(path).problems == ()


def test_an_imported_bag_states_that_it_is_real_and_what_was_asked_for(folder: Path, tmp_path: Path):
    (path,) = import_study(folder, tmp_path / "bags")
    facts = Bag(path).facts
    assert (facts["participant"], facts["task"], facts["study.origin"]) == ("u3", "lunch_packing", Origin.REAL)
    assert script_from(facts)[0] == ("milk", "box")


def test_an_imported_bag_reevaluates_to_what_it_holds(folder: Path, tmp_path: Path):
    (path,) = import_study(folder, tmp_path / "bags")
    comparisons = reevaluate(session_from_bag(Bag(path)))
    assert len(comparisons) == 3
    assert all(c.agrees for c in comparisons)


def test_right_and_wrong_survive_the_import(folder: Path, tmp_path: Path):
    (path,) = import_study(folder, tmp_path / "bags")
    answers = answers_of(session_from_bag(Bag(path)))
    assert answers is not None
    assert answers.is_right("milk", "juice")
    assert not answers.is_right("milk", "box")


def test_nothing_is_overwritten_and_then_nothing_is_written(folder: Path, tmp_path: Path):
    (tmp_path / "bags" / "u3_t2").mkdir(parents=True)
    with pytest.raises(BagError, match="u3_t2 exist"):
        import_study(folder, tmp_path / "bags")
    assert list((tmp_path / "bags" / "u3_t2").iterdir()) == []


def test_another_folder_is_refused_with_what_was_expected(tmp_path: Path):
    with pytest.raises(StudyFolderError, match="u2_t0"):
        import_study(tmp_path, tmp_path / "bags")


@given(
    name=st.sampled_from(sorted(FILES)),
    change=st.sampled_from(["absent", "empty", "cut", "line lost", "line twice", "no text"]),
    place=st.floats(0.0, 1.0, exclude_max=True),
)
def test_a_file_that_is_broken_is_named_or_harmless(
    name: str, change: str, place: float, tmp_path_factory: pytest.TempPathFactory
):
    root = tmp_path_factory.mktemp("broken")
    text = FILES[name]
    lines = text.splitlines(keepends=True)
    line = int(place * len(lines))
    changed = {
        "absent": None,
        "empty": b"",
        "cut": text[: int(place * len(text))].encode(),
        "line lost": "".join(lines[:line] + lines[line + 1 :]).encode(),
        "line twice": "".join(lines[: line + 1] + lines[line:]).encode(),
        "no text": text.encode() + b"\xff",
    }[change]
    for other, content in FILES.items():
        path = root / other
        path.parent.mkdir(parents=True, exist_ok=True)
        if other != name:
            path.write_text(content)
        elif changed is not None:
            path.write_bytes(changed)
    try:
        sessions = read_study(root)
    except StudyFolderError as error:
        assert str(root) in str(error)
        return
    for read in sessions:
        recorded_session(read)


def test_the_missing_hue_is_taken_as_the_study_took_it(folder: Path):
    (read,) = read_study(folder)
    assert read.task.source["box"].hue is None
    assert recorded_session(read).facts["parameter./mapping.missing_hue"] == str(STUDY_CONFIG.missing_hue)


@pytest.mark.parametrize("text", ["milk", ">box", "milk>"])
def test_a_script_that_cannot_be_read_is_refused(text: str):
    with pytest.raises(BagError, match=r"study\.script"):
        script_from({"study.script": text})
