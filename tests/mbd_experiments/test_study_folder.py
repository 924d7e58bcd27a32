"""The reader of the study's folder states what is wrong with one."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from mbd_experiments.public_study.study_data import main, replay
from mbd_experiments.public_study.study_folder import StudyFolderError, read_study, used_assists
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import STRATEGIES

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


def copy_of(session: Path, name: str) -> Path:
    """The same session under another name."""
    return Path(shutil.copytree(session, session.parent / name))


BROKEN = {
    "a file is missing": (lambda s: (s / "hints.txt").unlink(), "hints.txt"),
    "an object line is cut": (lambda s: (s / "source_objects.txt").write_text("cup,1.0,0.1\n"), "source_objects.txt:1"),
    "a number is none": (lambda s: (s / "target_objects.txt").write_text("a,1,1,x,1,1,1,1\n"), "target_objects.txt:1"),
    "a hue is no number": (lambda s: (s / "target_objects.txt").write_text("a,1,1,1,1,1,1,nan\n"), "hue nan"),
    "a box is flat": (lambda s: (s / "source_objects.txt").write_text("cup,1,1,1,8,0,5,90\n"), "source_objects.txt:1"),
    "an id is there twice": (lambda s: (s / "source_objects.txt").write_text(OBJECTS + OBJECTS), "unique"),
    "a scene is empty": (lambda s: (s / "target_objects.txt").write_text("\n"), "target_objects.txt is empty"),
    "a step names no object": (lambda s: (s / "targeters.txt").write_text("cup\ncup\n"), "targeters.txt:1"),
    "a step names an unknown object": (lambda s: (s / "targeters.txt").write_text("(jug)\n(cup)\n"), "'jug'"),
    "there is no step": (lambda s: (s / "targeters.txt").write_text("(cup)+0\n"), "no step"),
    "it is no text": (lambda s: (s / "targeters.txt").write_bytes(b"\xff\xfe\x00"), "UTF-8"),
}


@pytest.mark.parametrize("what", sorted(BROKEN))
def test_a_broken_session_is_named_and_costs_no_other(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The complete session is replayed and written all the same; the broken one stands on stderr, and the code is 1."""
    copy = copy_of(write_session(tmp_path), "u2_t0")
    spoil, reason = BROKEN[what]
    spoil(copy)
    out = tmp_path / "rows.csv"
    assert main([str(tmp_path), "--csv", str(out)]) == 1
    assert {line.split(",")[0] for line in out.read_text().splitlines()[1:]} == {"u1_t0"}
    printed = capsys.readouterr()
    assert "1 sessions" in printed.out
    assert "u2_t0 is left out" in printed.err
    assert reason in printed.err


@pytest.mark.parametrize("strategy", sorted(STRATEGIES))
def test_assists_that_cannot_be_are_asked_and_change_nothing(strategy: str, tmp_path: Path) -> None:
    """A hint of an object that is not there counts as asked; more hints than steps answer no step."""
    session = write_session(tmp_path)
    (session / "hints.txt").write_text("jug\nbowl\ncup\nbowl\n")
    (read,) = read_study(tmp_path)
    rows = replay(read, MappingConfig(strategy=strategy))
    assert [row.assists for row in rows] == [0, 1, 2]
    assert (rows[1].mapping, rows[1].confidence) == (rows[0].mapping, rows[0].confidence)
    assert "bowl:bowl" in rows[2].mapping


def test_no_assists_is_one_row(tmp_path: Path) -> None:
    """A session whose teacher never helped has a prediction."""
    session = write_session(tmp_path)
    (session / "hints.txt").write_text("")
    (read,) = read_study(tmp_path)
    assert len(replay(read, MappingConfig())) == 1


def test_knowledge_of_one_line_is_named(tmp_path: Path) -> None:
    """Without the properties no session can be read; the file is named."""
    write_session(tmp_path)
    (tmp_path / "knowledge" / "all.txt").write_text("affordances;cup:fillable")
    with pytest.raises(StudyFolderError, match=r"all\.txt.*one of properties"):
        read_study(tmp_path)


def test_rows_that_cannot_be_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A CSV path in no folder is an error with what to do."""
    write_session(tmp_path)
    assert main([str(tmp_path), "--csv", str(tmp_path / "none" / "rows.csv")]) == 1
    assert "--csv" in capsys.readouterr().err


def test_a_noise_that_cannot_be_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The option is that of the configuration, with its range."""
    write_session(tmp_path)
    options = [str(tmp_path), "--csv", str(tmp_path / "rows.csv"), "--strategy", "evidence", "--similarity-noise"]
    assert main([*options, "0.02"]) == 0
    assert main([*options, "2"]) == 1
    assert "similarity_noise" in capsys.readouterr().err


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
