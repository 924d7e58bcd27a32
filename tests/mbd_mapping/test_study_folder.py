"""The reader of the study's folder says what is wrong with one."""

from __future__ import annotations

from pathlib import Path

import pytest
from mbd_mapping.study_data import main
from mbd_mapping.study_folder import StudyFolderError, read_study, used_assists

OBJECTS = "cup,1.0,0.1,0.7,8,7,5,90.0,{a},{b}\nbowl,0.9,-0.2,0.7,9,8,6,-1000,{a},{b}\n"


def write_session(folder: Path) -> Path:
    """A small session, complete."""
    session = folder / "u1_t0"
    for made in (session, folder / "knowledge", folder / "solutions"):
        made.mkdir(parents=True)
    (session / "source_objects.txt").write_text(OBJECTS)
    (session / "target_objects.txt").write_text(OBJECTS)
    (session / "targeters.txt").write_text("(cup)+0.1,(cup)+3e+111,(cup)+0.2\n(bowl)+0,(bowl)+0,(bowl)+0\n(cup)+0\n")
    (session / "hints.txt").write_text("bowl\ncup\n")
    (folder / "knowledge" / "all.txt").write_text(
        "affordances;cup:fillable,pourable;bowl:fillable\nproperties;cup:full"
    )
    (folder / "solutions" / "t0.txt").write_text("cup:bowl\nbowl:cup\n")
    return session


def test_a_session_is_read(tmp_path: Path) -> None:
    """Lengths become metres, -1000 no hue, the knowledge is looked up, and the last line of the steps is none."""
    write_session(tmp_path)
    (session,) = read_study(tmp_path)
    cup, bowl = session.task.source.objects
    assert cup.size == (0.08, 0.07, 0.05)
    assert (cup.hue, bowl.hue) == (90.0, None)
    assert (cup.affordances, cup.properties) == ({"fillable", "pourable"}, {"full"})
    assert [s.primary_object for s in session.task.steps] == ["cup", "bowl"]
    assert [(a.source_id, a.target_id) for a in session.assists] == [("cup", "bowl"), ("bowl", "cup")]
    assert session.solved_by({"cup": "bowl", "bowl": "cup"})
    assert not session.solved_by({"cup": "bowl"})


def test_repeats_are_dropped() -> None:
    """An immediate repeat goes, and so does a pair in a row that repeats an earlier one (A B C A B to A B C)."""
    assert used_assists(["A", "A", "B"]) == ("A", "B")
    assert used_assists(["A", "B", "C", "A", "B"]) == ("A", "B", "C")
    assert used_assists(["A", "B", "C", "B", "D"]) == ("A", "B", "C", "B", "D")


def test_what_is_wrong_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An empty folder, a missing file and a broken line are each named."""
    assert main([str(tmp_path)]) == 1
    assert "no session folder" in capsys.readouterr().err
    session = write_session(tmp_path)
    (session / "source_objects.txt").write_text("cup,x\n")
    with pytest.raises(StudyFolderError, match=r"source_objects\.txt:1"):
        read_study(tmp_path)
    (session / "source_objects.txt").unlink()
    with pytest.raises(StudyFolderError, match="cannot read"):
        read_study(tmp_path)
