"""What goes into a bag comes out of it, through our reader and through other people's."""

from __future__ import annotations

import array
import inspect
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mbd_msgs import msg as m
from mbd_study.bag import Bag
from mbd_study.bag_metadata import TopicRecord, read_metadata
from mbd_study.bag_writer import BagWriter
from mbd_study.conversions import session_from_bag
from mbd_study.definitions import full_definition, type_hash
from mbd_study.message_writer import LATCHED, MessageWriter, message_type
from mbd_study.synthetic import SyntheticSession
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

MESSAGES = [cls for _, cls in inspect.getmembers(m, inspect.isclass)]


def filled(cls: type, numbers: Any) -> Any:
    """A message none of whose fields has its default."""
    msg = cls()
    for name in msg.get_fields_and_field_types():
        old = getattr(msg, name)
        kind = msg.get_fields_and_field_types()[name]
        setattr(msg, name, value_of(kind, old, numbers))
    return msg


def value_of(kind: str, old: Any, numbers: Any) -> Any:
    if kind.startswith("sequence<"):
        inner = kind.removeprefix("sequence<").removesuffix(">")
        return [value_of(inner, None, numbers) for _ in range(2)]
    if kind == "boolean":
        return True
    if kind in {"double", "float"}:
        return next(numbers) + 0.25
    if "int" in kind and "/" not in kind:
        return next(numbers) % 100 + 1
    if kind == "string":
        return f"text {next(numbers)} ä"
    if "[" in kind:
        return np.array([next(numbers) + 0.5 for _ in old])
    package, name = kind.split("/")
    return filled(getattr(__import__(f"{package}.msg", fromlist=[name]), name), numbers)


def same(read: Any, sent: Any) -> bool:
    if hasattr(sent, "get_fields_and_field_types"):
        return all(same(getattr(read, n), getattr(sent, n)) for n in sent.get_fields_and_field_types())
    if isinstance(sent, np.ndarray | array.array) or isinstance(read, np.ndarray):
        return list(read) == list(sent)
    if isinstance(sent, list):
        return len(read) == len(sent) and all(map(same, read, sent))
    return read == sent


@pytest.mark.parametrize("cls", MESSAGES, ids=lambda c: c.__name__)
def test_a_message_of_every_type_is_read_as_it_was_sent(cls: type, tmp_path: Path):
    sent = filled(cls, count(1))
    kind = message_type(sent)
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic(TopicRecord("/it", kind, type_hash(kind), (LATCHED,)), full_definition(kind))
        bag.write("/it", 7, serialize_message(sent))
    ((message, read),) = Bag(tmp_path / "bag").decoded()
    assert same(read, sent)
    assert deserialize_message(message.data, cls) == sent
    assert (message.topic, message.msgtype, message.log_time) == ("/it", kind, 7)


@pytest.mark.parametrize("cls", MESSAGES, ids=lambda c: c.__name__)
def test_our_own_encoding_is_what_ros_reads(cls: type, tmp_path: Path):
    sent = filled(cls, count(5))
    with BagWriter(tmp_path / "bag") as bag:
        assert deserialize_message(MessageWriter(bag).encode(sent), cls) == sent


@pytest.mark.parametrize("kind", [*(f"mbd_msgs/msg/{c.__name__}" for c in MESSAGES), "sensor_msgs/msg/PointCloud2"])
def test_the_embedded_definition_has_the_hash_ros_gives_the_type(kind: str):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(full_definition(kind), kind))
    assert store.hash_rihs01(kind) == type_hash(kind)


def test_a_whole_session_is_read_as_it_was_written(made: SyntheticSession, made_bag: Path):
    assert session_from_bag(Bag(made_bag)) == made.recorded


def test_a_single_file_of_a_bag_is_a_bag_too(made: SyntheticSession, made_bag: Path):
    assert session_from_bag(Bag(made_bag / "made_0.mcap")) == made.recorded


def test_rosbags_opens_a_finished_bag_with_its_definitions(made_bag: Path):
    ours = Bag(made_bag)
    with Reader(made_bag) as reader:
        assert reader.message_count == ours.message_count
        assert (reader.start_time, reader.end_time) == (ours.start, ours.end + 1)
        assert {c.topic: c.msgcount for c in reader.connections} == {t.name: t.count for t in ours.topics}
        store = get_typestore(Stores.EMPTY)
        for connection in reader.connections:
            assert connection.msgdef.format == MessageDefinitionFormat.MSG
            assert connection.digest.startswith("RIHS01_")
            assert connection.ext.offered_qos_profiles
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        theirs = [(c.topic, t, bytes(d)) for c, t, d in reader.messages()]
        for topic_connection, _, data in reader.messages():
            store.deserialize_cdr(data, topic_connection.msgtype)
    assert theirs == [(x.topic, x.log_time, x.data) for x in ours.messages()]


def test_the_mcap_library_reads_it_by_its_index(made_bag: Path):
    with (made_bag / "made_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        assert reader.get_summary().statistics.message_count == Bag(made_bag).message_count
        assert len(list(reader.iter_messages())) == Bag(made_bag).message_count
        schemas = {s.name: s for s in reader.get_summary().schemas.values()}
    assert {s.encoding for s in schemas.values()} == {"ros2msg"}


def test_metadata_yaml_says_everything_rosbag2_version_9_asks_for(made_bag: Path):
    information = read_metadata(made_bag)
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == ["made_0.mcap"] == [f["path"] for f in information["files"]]
    assert information["ros_distro"]
    assert information["custom_data"]["session"] == "made"
    assert information["duration"]["nanoseconds"] > 0
    topic = information["topics_with_message_count"][0]
    assert set(topic["topic_metadata"]) == {
        "name",
        "type",
        "serialization_format",
        "offered_qos_profiles",
        "type_description_hash",
    }
    assert topic["topic_metadata"]["offered_qos_profiles"][0]["history"] in {"keep_last", "keep_all"}


def test_messages_of_one_topic_and_time_are_found(made_bag: Path):
    bag = Bag(made_bag)
    wanted = [x for x in bag.messages() if x.topic == "/interaction/state" and 11e9 <= x.log_time < 40e9]
    assert list(bag.messages({"/interaction/state"}, 11_000_000_000, 40_000_000_000)) == wanted
    assert wanted
