"""`repair` keeps every message of every intact page of a sqlite3 bag, invents none, and touches nothing of the bag."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.repairing.sqlite.pages import open_pages
from mbd_bag.repairing.sqlite.rows import find_rows
from mbd_bag.repairing.trial_bags import sqlite_bag
from mbd_bag.repairing.trials import repair_trial, sqlite_trials
from mbd_bag.storage.bag import Bag
from mbd_bag.tools import repair
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

SAMPLE = Path(__file__).resolve().parents[2] / "bags" / "stacking"
STORE = get_typestore(Stores.ROS2_JAZZY)
COUNT = 90
PAGE = 4096


def write_bag(folder: Path) -> Path:
    """Texts on two topics, of 4 bytes to three pages, and numbers on a third."""
    with RosbagsWriter(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        kinds = {"/words": "String", "/more": "String", "/number": "Int64"}
        topics = {t: bag.add_connection(t, f"std_msgs/msg/{k}", typestore=STORE) for t, k in kinds.items()}
        for k in range(COUNT):
            topic = ("/words", "/more", "/number", "/words")[k % 4]
            kind = f"std_msgs/msg/{kinds[topic]}"
            value = k if topic == "/number" else f"{k} " + chr(97 + k % 26) * (9000 if k % 9 == 1 else k * 7)
            message = STORE.types[kind](data=value)
            bag.write(topics[topic], 1_000_000_000 * (k + 1), STORE.serialize_cdr(message, kind))
    return folder


@pytest.fixture(scope="module")
def intact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("intact") / "bag")


def contents(path: Path) -> Counter[tuple[str, int, bytes]]:
    return Counter((m.topic, m.log_time, m.data) for m in Bag(path).messages())


def damaged(bag: Path, folder: Path, change: Callable[[bytearray], object]) -> Path:
    """A copy of a bag whose file is changed."""
    shutil.copytree(bag, folder)
    file = next(folder.glob("*.db3"))
    data = bytearray(file.read_bytes())
    change(data)
    file.write_bytes(data)
    return folder


def put(place: int, value: bytes) -> Callable[[bytearray], object]:
    return lambda data: data.__setitem__(slice(place, place + len(value)), value)


@settings(max_examples=30)
@given(data=st.data())
def test_whatever_is_flipped_or_cut_every_message_of_an_intact_page_is_kept_and_none_invented(
    data: st.DataObject, intact: Path, tmp_path_factory: pytest.TempPathFactory
):
    changed = bytearray((intact / "bag.db3").read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(changed) - 1), max_size=12), "flipped"):
        changed[place] ^= data.draw(st.integers(1, 255), "by")
    if data.draw(st.booleans(), "cut"):
        end = data.draw(st.integers(1, len(changed)), "at")
        del changed[end // PAGE * PAGE if data.draw(st.booleans(), "at a page's border") else end :]
    trial = repair_trial(sqlite_bag(intact), bytes(changed), "", tmp_path_factory.mktemp("trial"))
    assert (trial.kept, trial.invented, trial.failure) == (trial.intact, 0, "")


def test_a_session_stored_by_sqlite3_keeps_what_is_intact(tmp_path: Path):
    trials = list(sqlite_trials([SAMPLE], 1, 4, tmp_path))
    assert min(t.intact for t in trials) > 5000
    assert all((t.kept, t.invented, t.failure) == (t.intact, 0, "") for t in trials)


ALL_KEPT = {
    "first page": lambda bag: put(0, b"\xff" * PAGE),
    "stated size of pages": lambda bag: put(16, b"\x20\x00"),
    "page of topics": lambda bag: put(page_with(bag, b"/words"), b"\0" * PAGE),
    "name of a topic": lambda bag: lambda data: data.__setitem__(data.index(b"/words"), ord("_")),
    "type of a topic": lambda bag: lambda data: data.__setitem__(data.index(b"std_msgs/msg/Int64"), ord("q")),
    "definition": lambda bag: lambda data: data.__setitem__(data.index(b"int64 data"), ord("x")),
}


def page_with(bag: Path, text: bytes) -> int:
    """Where the page begins that has a text first [byte]."""
    return (bag / "bag.db3").read_bytes().index(text) // PAGE * PAGE


@pytest.mark.parametrize("kind", ALL_KEPT)
def test_what_says_how_to_read_the_messages_is_had_from_elsewhere(kind: str, intact: Path, tmp_path: Path):
    hurt = damaged(intact, tmp_path / "bag", ALL_KEPT[kind](intact))
    repair.repair(hurt, tmp_path / "out")
    assert contents(tmp_path / "out") == contents(intact)
    with Reader(tmp_path / "out") as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == {"/words": 45, "/more": 23, "/number": 22}


def test_a_message_that_would_go_on_in_the_pages_of_another_is_left_out(intact: Path, tmp_path: Path):
    # Two of equal size: only their places tell whose the pages are.
    long = [r for r in find_rows(open_pages(intact / "bag.db3")).messages if r.cell.onward]
    one, other = next((a, b) for a in long for b in long if a.id < b.id and a.cell.size == b.cell.size)
    end = (one.page - 1) * PAGE + one.cell.start + one.cell.local
    hurt = damaged(intact, tmp_path / "bag", put(end, other.cell.onward.to_bytes(4, "big")))
    repair.repair(hurt, tmp_path / "out")
    lost = contents(intact) - contents(tmp_path / "out")
    assert [time for _, time, _ in lost] == [one.time]
    assert not contents(tmp_path / "out") - contents(intact)


@pytest.mark.parametrize(("column", "sentence"), [("topic", "none of their topic's type"), ("time", "time is damaged")])
def test_a_column_that_something_else_contradicts_costs_its_message_only(
    column: str, sentence: str, intact: Path, tmp_path: Path
):
    row = next(r for r in find_rows(open_pages(intact / "bag.db3")).messages if r.id == 23)
    place = (row.page - 1) * PAGE + row.cell.start
    at = (intact / "bag.db3").read_bytes().index(row.time.to_bytes(6, "big"), place)
    change = put(at, b"\x7f") if column == "time" else put(at - 1, b"\x02")
    hurt = damaged(intact, tmp_path / "bag", change)
    (file,) = repair.repair(hurt, tmp_path / "out")
    assert contents(intact) - contents(tmp_path / "out") == Counter(k for k in contents(intact) if k[1] == row.time)
    assert not contents(tmp_path / "out") - contents(intact)
    assert any(sentence in said for said in file.sentences), file.sentences
