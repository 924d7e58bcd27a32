"""A disk that takes nothing for a while costs a recording nothing."""

from __future__ import annotations

import itertools
import resource
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.mcap_file import McapFile
from mbd_bag.storage.record_file import RecordFile


@given(
    records=st.lists(st.binary(min_size=1, max_size=300), min_size=1, max_size=12),
    room=st.integers(0, 1500),
    more_after=st.integers(0, 12),
)
def test_records_that_the_disk_has_no_room_for_are_held_whole_and_written_in_order_when_it_has(
    records: list[bytes], room: int, more_after: int, tmp_path_factory: pytest.TempPathFactory
):
    path = tmp_path_factory.mktemp("full") / "file"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    file = RecordFile(path)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
        for record in records[:more_after]:
            file.write(record)
        fitting = list(
            itertools.takewhile(lambda end: end <= room, itertools.accumulate(map(len, records[:more_after])))
        )
        assert path.stat().st_size == (fitting[-1] if fitting else 0)
        assert path.stat().st_size + file.held == file.tell() == sum(map(len, records[:more_after]))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    for record in records[more_after:]:
        file.write(record)
    file.flush()
    assert file.held == 0
    file.close()
    assert path.read_bytes() == b"".join(records)


def test_a_bag_that_ends_while_the_disk_takes_nothing_says_so(tmp_path: Path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    file = RecordFile(tmp_path / "file")
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (5, before[1]))
        file.write(b"too much")
        with pytest.raises(OSError, match="too large"):
            file.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert file.closed and (tmp_path / "file").read_bytes() == b""


def test_a_recording_goes_on_through_a_disk_that_takes_nothing_for_a_while(tmp_path: Path):
    """What comes meanwhile is in the bag; nobody is told that it is safe before it is."""
    safe: list[int] = []
    warned: list[str] = []
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = BagWriter(tmp_path / "bag")
    thread = WritingThread(
        writer, flush_period=0.01, warn=warned.append, flushed=lambda _: safe.append(writer.path.stat().st_size)
    )
    thread.add_topic(TopicRecord("/wizard/note", "mbd_msgs/msg/WizardNote"), "string text\n")
    try:
        _wait(lambda: bool(safe))
        resource.setrlimit(resource.RLIMIT_FSIZE, (writer.path.stat().st_size, before[1]))
        for k in range(20):
            thread.write("/wizard/note", k, b"\x00\x01\x00\x00\x01\x00\x00\x00\x00")
        _wait(lambda: bool(warned))
        size, said = writer.path.stat().st_size, len(safe)
        thread.write("/wizard/note", 20, b"\x00\x01\x00\x00\x01\x00\x00\x00\x00")
        _wait(lambda: thread.backlog == 0)
        assert writer.path.stat().st_size == size and len(safe) == said
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    _wait(lambda: len(safe) > said)
    thread.close()
    assert thread.failure is None and "held in memory" in warned[0]
    assert McapFile(writer.path).contents.counts == {1: 21}


def _wait(until: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30.0
    while not until():
        assert time.monotonic() < deadline
        time.sleep(0.005)
