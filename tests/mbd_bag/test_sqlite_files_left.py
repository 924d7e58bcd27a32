"""What a writer that died leaves of a sqlite3 bag, what compression leaves, and files made to be read without end."""

from __future__ import annotations

import shutil
import sqlite3
import sys
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest
import zstandard
from mbd_bag.errors import BagError
from mbd_bag.formats.sqlite_file import SqliteFile
from mbd_bag.storage.bag import Bag
from mbd_bag.tools import repair
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
    serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
    data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO topics VALUES(1, '/words', 'std_msgs/msg/String', 'cdr', '');
"""


def text(number: int) -> bytes:
    """A message of up to three pages."""
    return bytes(
        STORE.serialize_cdr(STORE.types["std_msgs/msg/String"]("x" * (number * 137 % 9000)), "std_msgs/msg/String")
    )


def killed_writer(folder: Path, journal: str) -> Path:
    """A file of five transactions of 40 messages and one that is not committed, with what lay beside it."""
    folder.mkdir()
    whole = folder / "whole.db3"
    with closing(sqlite3.connect(whole, isolation_level=None)) as database:
        database.execute(f"PRAGMA journal_mode = {journal}")
        database.execute("PRAGMA cache_size = 10")
        database.execute("PRAGMA wal_autocheckpoint = 20")
        database.executescript(TABLES)
        for batch in range(6):
            database.execute("BEGIN")
            rows = ((1, 1000 * k, text(k)) for k in range(40 * batch, 40 * batch + 40))
            database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", rows)
            if batch < 5:
                database.execute("COMMIT")
        bag = folder / "bag"
        bag.mkdir()
        for suffix in ("", "-wal", "-journal"):
            if (beside := whole.with_name(whole.name + suffix)).exists():
                shutil.copy(beside, bag / f"bag_0.db3{suffix}")
        database.execute("ROLLBACK")
    return bag


def numbers(path: Path) -> list[int]:
    """Which messages of `text` a bag holds; each must have its bytes."""
    found = [(m.log_time // 1000, m.data) for m in Bag(path).messages()]
    assert all(data == text(number) for number, data in found)
    return [number for number, _ in found]


@pytest.mark.parametrize(("journal", "left"), [("WAL", "-wal"), ("DELETE", "-journal"), ("MEMORY", "")])
def test_what_a_dead_writer_had_written_is_kept_also_what_it_had_not_committed(journal: str, left: str, tmp_path: Path):
    bag = killed_writer(tmp_path / "killed", journal)
    assert {p.name for p in bag.iterdir()} == {"bag_0.db3", f"bag_0.db3{left}"}
    before = {p: p.read_bytes() for p in bag.iterdir()}
    assert any("its writer died" in problem for problem in repair.problems_of(bag))
    repair.repair(bag, tmp_path / "out")
    kept = numbers(tmp_path / "out")
    assert kept == list(range(len(kept)))
    assert len(kept) > 200
    assert {p: p.read_bytes() for p in before} == before


def test_a_damaged_frame_of_a_write_ahead_log_costs_what_it_holds_only(tmp_path: Path):
    bag = killed_writer(tmp_path / "killed", "WAL")
    log = bag / "bag_0.db3-wal"
    whole = log.read_bytes()
    repair.repair(bag, tmp_path / "before")
    for place in (40, len(whole) // 2, len(whole) - 5000):
        log.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        out = tmp_path / f"out_{place}"
        repair.repair(bag, out)
        assert set(numbers(tmp_path / "before")) >= set(numbers(out))
        assert len(numbers(out)) >= len(numbers(tmp_path / "before")) - 40


def test_an_intact_file_of_a_folder_that_cannot_be_written_is_read_and_leaves_nothing(tmp_path: Path):
    with closing(sqlite3.connect(tmp_path / "bag.db3")) as database:
        database.execute("PRAGMA journal_mode = WAL")
        database.executescript(TABLES)
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, 1, ?)", (text(1),))
        database.commit()
    tmp_path.chmod(0o500)
    try:
        assert SqliteFile(tmp_path / "bag.db3").contents.counts == {1: 1}
        assert [p.name for p in tmp_path.iterdir()] == ["bag.db3"]
    finally:
        tmp_path.chmod(0o700)


def written(folder: Path, plugin: StoragePlugin, mode: CompressionMode) -> Path:
    bag = RosbagsWriter(folder, version=9, storage_plugin=plugin)
    if mode is not CompressionMode.NONE:
        bag.set_compression(mode, CompressionFormat.ZSTD)
    with bag:
        connection = bag.add_connection("/words", "std_msgs/msg/String", typestore=STORE)
        for k in range(1, 200):
            bag.write(connection, 1000 * k, text(k))
    return folder


@pytest.mark.parametrize("plugin", list(StoragePlugin), ids=lambda p: p.name)
def test_a_compressed_file_that_is_cut_off_keeps_what_can_be_unpacked(plugin: StoragePlugin, tmp_path: Path):
    bag = written(tmp_path / "bag", plugin, CompressionMode.NONE)
    (file,) = (p for p in bag.iterdir() if p.suffix != ".yaml")
    packed = zstandard.ZstdCompressor(level=-5).compress(file.read_bytes())
    file.unlink()
    (bag / "metadata.yaml").unlink()
    (bag / f"{file.name}.zstd").write_bytes(packed[: len(packed) * 3 // 4])
    (became,) = repair.repair(bag, tmp_path / "out")
    assert "cannot be unpacked" in became.sentences[0]
    kept = numbers(tmp_path / "out")
    assert kept == list(range(1, 1 + len(kept)))
    assert kept


def test_messages_that_are_compressed_one_by_one_are_unpacked_without_metadata(tmp_path: Path):
    bag = written(tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
    (bag / "metadata.yaml").unlink()
    repair.repair(bag, tmp_path / "out")
    assert numbers(tmp_path / "out") == list(range(1, 200))


def test_the_tool_says_what_it_kept_and_overwrites_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    bag = written(tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.NONE)
    file = bag / "bag.db3"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    before = Counter(p.read_bytes() for p in bag.iterdir())
    monkeypatch.setattr(sys, "argv", ["repair", str(bag)])
    for code, words in ((0, "more are lost, by metadata.yaml"), (2, "is not overwritten")):
        with pytest.raises(SystemExit) as ended:
            repair.main()
        said = capsys.readouterr()
        assert (ended.value.code, words in " ".join((said.out + said.err).split())) == (code, True), said
    assert Counter(p.read_bytes() for p in bag.iterdir()) == before
    assert Bag(tmp_path / "bag_repaired").check() == ()


def tree_without_end(path: Path) -> None:
    """A table whose pages name the next ones over and over: few pages, and more rows than anyone can count."""
    size, levels = 512, 6
    with closing(sqlite3.connect(path)) as database:
        database.execute(f"PRAGMA page_size = {size}")
        database.executescript(TABLES.replace("CREATE INDEX timestamp_idx ON messages (timestamp ASC);", ""))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, 1, ?)", (text(0),))
        database.commit()
        (root,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'").fetchone()
    data = bytearray(path.read_bytes())
    pages = len(data) // size
    leaf = bytes(data[(root - 1) * size : root * size])

    def inner(onward: int) -> bytes:
        cells = [onward.to_bytes(4, "big") + bytes([k + 1]) for k in range(60)]
        places = [size - 5 * (k + 1) for k in range(60)]
        head = b"\x05\0\0" + len(cells).to_bytes(2, "big") + places[-1].to_bytes(2, "big") + b"\0"
        head += onward.to_bytes(4, "big") + b"".join(p.to_bytes(2, "big") for p in places)
        return head + bytes(size - len(head) - 5 * len(cells)) + b"".join(reversed(cells))

    data[(root - 1) * size : root * size] = inner(pages + 1)
    for level in range(1, levels):
        data += inner(pages + level + 1)
    data += leaf
    data[28:32] = (len(data) // size).to_bytes(4, "big")
    path.write_bytes(data)


def test_a_file_of_a_few_pages_that_names_them_without_end_is_refused_in_one_sentence(tmp_path: Path):
    tree_without_end(tmp_path / "bag.db3")
    with pytest.raises(BagError, match="asks for more than reading a file of its size takes"):
        SqliteFile(tmp_path / "bag.db3")
    repair.repair(tmp_path / "bag.db3", tmp_path / "out")
    assert numbers(tmp_path / "out") == [0]


def test_rows_of_no_topic_are_said(tmp_path: Path):
    with closing(sqlite3.connect(tmp_path / "bag.db3")) as database:
        database.executescript(TABLES)
        rows = [(topic, k, text(k)) for k, topic in enumerate((1, 1, 7))]
        database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", rows)
        database.commit()
    assert any("1 of its messages belong to no topic" in problem for problem in Bag(tmp_path / "bag.db3").problems)
