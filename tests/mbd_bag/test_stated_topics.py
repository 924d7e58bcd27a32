"""Messages whose topic only a damaged chunk declared get it from metadata.yaml, or are left out; never another's."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from mbd_bag.errors import BagError
from mbd_bag.repairing.partial_chunk import definition_hash
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import FileRecord, TopicRecord, write_metadata
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.tools.repair import repair
from mcap.records import Schema
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
        cut: whether the third chunk and the index are missing; else every name in the index is damaged.
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
    for topic in channels:
        place = data.rindex(topic.encode() + b"\x03\0\0\0cdr")
        data[place : place + 2] = b"??"
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


def with_a_damaged_index(folder: Path, change: tuple[bytes, bytes], *, hashed: bool = True) -> Path:
    """A bag of a type that is known nowhere else; its only declaration besides lies in an index of wrong checksum.

    Args:
        folder: to write.
        change: what of the index stands there, and what in its place.
        hashed: whether metadata.yaml states the type's hash.
    """
    kind, text = "lab_msgs/msg/Note", "# what was said\nstring data\n"
    folder.mkdir()
    path = folder / "bag_0.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema(kind, "ros2msg", text.encode())
        channels = {topic: writer.register_channel(topic, "cdr", schema) for topic in ("/a", "/b")}
        for time in range(3):
            for topic, channel in channels.items():
                writer.add_message(channel, time, serialize_message(String(data=topic)), time)
            writer.flush()
        index = stream.tell()
        writer.finish()
    data = bytearray(path.read_bytes())
    begin = data.index(b"\x04\0\0\0zstd") + 16
    data[begin : begin + 8] = b"\xff" * 8
    data[-40] ^= 0xFF
    old, new = change
    place = data.index(old, index)
    data[place : place + len(old)] = new
    path.write_bytes(data)
    stated = definition_hash(Schema(1, text.encode(), "ros2msg", kind)) if hashed else ""
    topics = [TopicRecord(topic, kind, stated) for topic in ("/a", "/b")]
    write_metadata(folder, topics, [FileRecord(path.name, 0, 2, {"/a": 3, "/b": 3})], {}, "jazzy")
    return folder


def test_the_hash_of_a_definition_is_that_of_ros():
    for kind in {kind for kind, _ in KINDS.values()}:
        assert definition_hash(Schema(1, full_definition(kind).encode(), "ros2msg", kind)) == type_hash(kind)


def test_by_an_index_whose_checksum_is_wrong_where_metadata_states_the_same(tmp_path: Path):
    bag = with_a_damaged_index(tmp_path / "bag", (b"what was said", b"whXt was said"))
    assert kept(bag, tmp_path / "out") == {("/a", "lab_msgs/msg/Note"): 2, ("/b", "lab_msgs/msg/Note"): 2}
    assert all(msg.data == message.topic for message, msg in Bag(tmp_path / "out").decoded())


@pytest.mark.parametrize(
    ("change", "left"),
    [((b"string data", b"string dXta"), set()), ((b"/a\x03", b"/b\x03"), set())],
    ids=["its definition", "its name is another's"],
)
def test_not_by_an_index_in_which_it_is_damaged(change: tuple[bytes, bytes], left: set[str], tmp_path: Path):
    found = kept(with_a_damaged_index(tmp_path / "bag", change), tmp_path / "out")
    assert {topic for topic, _ in found} == left


def test_by_their_number_whose_name_is_damaged_in_the_index_and_the_others_is_not(tmp_path: Path):
    bag = with_a_damaged_index(tmp_path / "bag", (b"/a\x03", b"/c\x03"))
    assert kept(bag, tmp_path / "out") == {("/a", "lab_msgs/msg/Note"): 2, ("/b", "lab_msgs/msg/Note"): 2}


def test_not_by_an_index_whose_checksum_is_wrong_where_no_hash_is_stated(tmp_path: Path):
    change = b"what was said", b"whXt was said"
    assert kept(with_a_damaged_index(tmp_path / "bag", change, hashed=False), tmp_path / "out") == Counter()
