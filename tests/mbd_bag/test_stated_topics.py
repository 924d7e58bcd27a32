"""Messages whose topic only a damaged chunk declared get it from metadata.yaml, or are left out; never another's."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import FileRecord, TopicRecord, write_metadata
from mbd_bag.storage.definitions import full_definition
from mbd_bag.tools.repair import repair
from mcap.writer import Writer
from rclpy.serialization import serialize_message
from std_msgs.msg import Bool, Float64MultiArray, String, UInt16

KINDS = {
    "/a": ("std_msgs/msg/String", String(data="a text")),
    "/b": ("std_msgs/msg/Bool", Bool(data=True)),
    "/c": ("std_msgs/msg/UInt16", UInt16(data=7)),
    "/d": ("std_msgs/msg/Float64MultiArray", Float64MultiArray(data=[0.1, 0.2])),
    "/e": ("std_msgs/msg/String", String(data="another text")),
}


def damaged(folder: Path, order: str, counts: dict[str, int], *, cut: bool) -> Path:
    """A bag whose only declarations lie in its first chunk, which is damaged from its first byte on.

    Args:
        folder: to write.
        order: of the topics as the file numbers them.
        counts: of messages, by topic, in the second chunk; the first and third have one of each.
        cut: whether the third chunk and the index are missing; else the index is damaged.
    """
    folder.mkdir()
    path = folder / "bag_0.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        channels = {}
        for topic in (f"/{letter}" for letter in order):
            kind = KINDS[topic][0]
            schema = writer.register_schema(kind, "ros2msg", full_definition(kind).encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        ends = []
        for rows in (dict.fromkeys(counts, 1), counts, dict.fromkeys(counts, 1)):
            for topic, count in rows.items():
                for k in range(count):
                    writer.add_message(channels[topic], len(ends), serialize_message(KINDS[topic][1]), k)
            writer.flush()
            ends.append(stream.tell())
        writer.finish()
    data = bytearray(path.read_bytes())
    begin = data.index(b"\x04\0\0\0zstd") + 16
    data[begin : begin + 8] = b"\xff" * 8
    data[-40] ^= 0xFF
    path.write_bytes(data[: ends[1]] if cut else data)
    total = {topic: count + 2 for topic, count in counts.items()}
    topics = [TopicRecord(topic, KINDS[topic][0]) for topic in sorted(counts)]
    write_metadata(folder, topics, [FileRecord(path.name, 0, 2, total)], {}, "jazzy")
    return folder


def kept(folder: Path, out: Path) -> Counter[tuple[str, str]]:
    try:
        repair(folder, out)
    except BagError as error:
        assert "no message" in str(error)
        return Counter()
    return Counter((m.topic, m.msgtype) for m in Bag(out).messages())


def expected(counts: dict[str, int], more: int) -> Counter[tuple[str, str]]:
    return Counter({(topic, KINDS[topic][0]): count + more for topic, count in counts.items()})


@pytest.mark.parametrize("order", ["abcde", "debca"])
def test_by_their_number_where_all_message_indexes_are_there(order: str, tmp_path: Path):
    counts = {"/a": 5, "/b": 6, "/c": 7, "/d": 5, "/e": 8}
    assert kept(damaged(tmp_path / "bag", order, counts, cut=False), tmp_path / "out") == expected(counts, 1)


def test_by_their_order_where_the_file_is_cut(tmp_path: Path):
    counts = {"/a": 5, "/b": 6, "/c": 7, "/d": 5, "/e": 5}
    assert kept(damaged(tmp_path / "bag", "abcde", counts, cut=True), tmp_path / "out") == expected(counts, 0)


def test_none_where_the_file_is_cut_and_numbers_its_topics_otherwise(tmp_path: Path):
    counts = {"/a": 5, "/b": 6, "/c": 7, "/d": 5, "/e": 5}
    assert kept(damaged(tmp_path / "bag", "debca", counts, cut=True), tmp_path / "out") == Counter()


def test_none_of_two_topics_that_nothing_tells_apart(tmp_path: Path):
    counts = {"/a": 5, "/b": 6, "/c": 7, "/d": 5, "/e": 5}
    found = kept(damaged(tmp_path / "bag", "debca", counts, cut=False), tmp_path / "out")
    assert found == expected({k: n for k, n in counts.items() if k in ("/b", "/c", "/d")}, 1)
