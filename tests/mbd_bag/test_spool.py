"""What is spooled outlives every cut, and a recorder takes from it exactly what it missed."""

from __future__ import annotations

import random
import resource
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.recorder.parameters import RECORDER, recorder_config
from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.ros.missed_messages import MissedMessages
from mbd_bag.spool.parameters import WRITERS
from mbd_bag.spool.reconciliation import Reconciliation
from mbd_bag.spool.spool_file import SpooledMessage, SpoolReader, SpoolWriter, spool_path
from mbd_bag.spool.written_keys import KeyLog, keys_path, known_keys, logged_keys
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.mcap_file import McapFile
from rosbags.rosbag2 import Reader

KIND = "std_msgs/msg/String"


def message(topic: str, number: int, data: bytes = b"word") -> SpooledMessage:
    return SpooledMessage(topic, KIND, 10**18 + number, number, 10**18 + number, number, data)


MESSAGES = st.lists(st.tuples(st.sampled_from(["/wizard/note", "/interaction/state"]), st.binary(max_size=40)))


@given(made=MESSAGES, cut=st.integers(0, 60), limit=st.sampled_from([100, 300, 1 << 20]))
def test_a_journal_that_is_cut_anywhere_is_read_up_to_there_and_gone_on_with(made, cut: int, limit: int):
    sent = [message(topic, k, data) for k, (topic, data) in enumerate(made)]
    with TemporaryDirectory() as folder:
        path = spool_path(Path(folder), "1a")
        reader, read = SpoolReader(path), []
        writer = SpoolWriter(path, limit)
        for each in sent:
            writer.append(each)
            read += reader.new()
        writer.close()
        assert read == sent
        # Its writer is killed amid an entry.
        size = path.stat().st_size
        with path.open("r+b") as stream:
            stream.truncate(max(0, size - cut))
        again = SpoolWriter(path, limit)
        late = message("/late", 99)
        again.append(late)
        again.close()
        found = list(SpoolReader(path).new())
        assert found[-1] == late
        assert found[:-1] == [m for m in sent if m in found]
        assert cut or found[:-1] == sent[len(sent) - len(found) + 1 :]


def test_what_a_full_disk_does_not_take_is_held_and_written_once_it_does(tmp_path: Path):
    path = spool_path(tmp_path, "")
    writer = SpoolWriter(path)
    sent = [message("/wizard/note", k, b"x" * 5000) for k in range(4)]
    writer.append(sent[0])
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (6000, before[1]))  # the second fits in part only
    try:
        for each in sent[1:]:
            writer.append(each)
        assert not writer.flush()
        assert list(SpoolReader(path).new()) == sent[:1]
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert writer.flush()
    assert list(SpoolReader(path).new()) == sent
    assert not writer.held
    writer.close()


@given(
    topics=st.lists(st.sampled_from("ab"), max_size=30),
    ends=st.lists(st.tuples(st.integers(0, 8), st.integers(-2, 2), st.integers(0, 5)), max_size=4),
)
def test_every_message_is_in_the_bag_once_however_often_its_recorder_is_killed(topics: list[str], ends):
    """A recorder writes so many, its log says some less or (after a power cut) more; then so many fall into a gap."""
    sent = [message(topic, k) for k, topic in enumerate(topics)]
    bag: dict[str, list[SpooledMessage]] = {}
    now = 0
    with TemporaryDirectory() as folder:
        log = keys_path(Path(folder), "1a")
        for number, (takes, unsaid, gap) in enumerate([*ends, (len(sent), 0, 0)]):
            counts = {file: {t: sum(m.topic == t for m in held) for t in "ab"} for file, held in bag.items()}
            mine = Reconciliation(known_keys(logged_keys(log), counts, sent[:now]))
            for each in sent[:now]:
                mine.spooled(each, 0.0)
            written = mine.missing(float("inf"))
            assert not mine.missing(float("inf"))
            written += [m for m in sent[now : now + takes] if mine.receive(m.key)]
            now = min(len(sent), now + takes)
            keys = KeyLog(log)
            keys.add(f"bag_{number}", [m.key for m in written[: len(written) - max(unsaid, 0)]])
            keys.close()
            bag[f"bag_{number}"] = written[: len(written) - max(-unsaid, 0)] if number < len(ends) else written
            now = min(len(sent), now + gap)
    in_bag = [m for held in bag.values() for m in held]
    assert sorted(in_bag, key=lambda m: m.number) == sent


@given(parts=st.lists(st.sampled_from(["first", "second", "both"]), max_size=12), later=st.integers(0, 12))
def test_what_either_of_two_journals_has_is_taken_in_once_and_in_order(parts: list[str], later: int):
    """Some of it before the recorder looks for the first time, the rest after."""
    sent = [message("/word", k) for k in range(len(parts))]
    with TemporaryDirectory() as folder:
        journals = [SpoolWriter(spool_path(Path(folder), "1a", writer)) for writer in WRITERS]
        config = recorder_config(RECORDER.values({"bag": f"{folder}/bag", "spool": folder, "run": "1a"}))
        for each, part in zip(sent[:later], parts, strict=False):
            for journal in journals[part == "second" : 1 + (part != "first")]:
                journal.append(each)
        missed = MissedMessages(config, {}, lambda _: None)
        taken = missed.missing(everything=True)
        assert taken == sent[:later]
        for each, part in zip(sent[later:], parts[later:], strict=True):
            for journal in journals[part == "second" : 1 + (part != "first")]:
                journal.append(each)
        assert missed.missing(everything=True) == sent[later:]
        missed.close()
        for journal in journals:
            journal.close()


def test_a_message_that_arrives_late_is_taken_from_the_journal_or_by_itself_and_never_twice():
    mine = Reconciliation(grace=3.0)
    early, late, lost = (message("/a", k) for k in range(3))
    for each in (early, late, lost):
        mine.spooled(each, 10.0)
    assert mine.receive(early.key)
    assert mine.missing(12.9) == []
    assert mine.receive(late.key)
    assert mine.missing(13.0) == [lost]
    assert not mine.receive(lost.key)
    mine.spooled(lost, 14.0)
    assert mine.missing(99.0) == []


@pytest.mark.parametrize("line", ["", "{", '{"file": 1}', "[]", '{"file": "f", "keys": {"/a": [[1]]}}', "\x00\x01"])
def test_a_line_of_the_log_that_was_cut_off_costs_that_line_only(tmp_path: Path, line: str):
    log = keys_path(tmp_path, "")
    first = KeyLog(log)
    first.add("bag_0.mcap", [("/a", 1, 1)])
    first.close()
    with log.open("a") as stream:
        stream.write(line)
    second = KeyLog(log)
    second.add("bag_0.mcap", [("/a", 2, 2)])
    second.close()
    assert logged_keys(log)["bag_0.mcap"]["/a"] == [("/a", 1, 1), ("/a", 2, 2)]


def test_what_was_synced_is_in_a_bag_that_loses_power(tmp_path: Path):
    """A power cut is simulated: of the file is left what the disk was made to keep."""
    writer = BagWriter(tmp_path / "bag")
    thread = WritingThread(writer, flush_period=0.1)
    thread.add_topic(TopicRecord("/word", KIND, type_hash(KIND)), full_definition(KIND))
    thread.write("/word", 7, bytes(12))
    end = time.monotonic() + 30.0
    while not writer.synced[1]:  # the period is in `writing_thread`: 1 s
        assert time.monotonic() < end, "nothing was synced"
        time.sleep(0.01)
    cut = tmp_path / "cut" / "cut_0.mcap"
    cut.parent.mkdir()
    cut.write_bytes(writer.path.read_bytes()[: writer.synced[1]])
    thread.close()
    assert [m.log_time for m in Bag(cut.parent).messages()] == [7]


def test_a_bag_goes_on_in_its_next_file_once_one_is_full_and_a_kill_leaves_the_last_to_be_read_again(tmp_path: Path):
    folder = tmp_path / "bag"
    writer = BagWriter(folder)
    thread = WritingThread(writer, flush_period=0.01, file_size=2000)
    thread.add_topic(TopicRecord("/word", KIND, type_hash(KIND)), full_definition(KIND))
    thread.add_facts({"task": "sorting"})
    sent = 0
    end = time.monotonic() + 30.0
    while len(list(folder.glob("*.mcap"))) < 4:
        assert time.monotonic() < end, "no next file was begun"
        thread.write("/word", sent, random.Random(sent).randbytes(100))
        sent += 1
        time.sleep(0.002)
    # As a kill would leave it: without the last file's end, and without metadata.yaml.
    killed = tmp_path / "killed"
    killed.mkdir()
    for path in sorted(folder.glob("*.mcap")):
        (killed / path.name.replace("bag", "killed")).write_bytes(path.read_bytes())
    thread.close()
    assert [m.log_time for m in Bag(folder).messages()] == list(range(sent))
    assert Bag(folder).problems == ()
    with Reader(folder) as reader:
        assert reader.message_count == sent
    files = [McapFile(path).complete for path in sorted(killed.iterdir())]
    assert files == [True] * (len(files) - 1) + [False]
    with BagWriter(killed) as resumed:
        assert len(resumed.earlier) == len(files)
        assert sum(resumed.counts.values()) >= sent // 2
