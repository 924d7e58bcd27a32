"""What goes into a bag comes out of it, through our reader and through other people's."""

from __future__ import annotations

import array
import inspect
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord, read_metadata
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.message_writer import LATCHED, MessageWriter, message_type
from mbd_msgs import msg as m
from mbd_study.synthetic import SyntheticSession
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

BAGS = Path(__file__).resolve().parents[2] / "bags"
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


def test_a_complete_session_is_read_as_it_was_written(made: SyntheticSession, made_bag: Path):
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


# What rosbag2 (Jazzy) takes for the policies of a profile in version 9; another word makes it refuse the bag.
POLICIES = {
    "history": {"system_default", "keep_last", "keep_all", "unknown"},
    "reliability": {"system_default", "reliable", "best_effort", "unknown", "best_available"},
    "durability": {"system_default", "transient_local", "volatile", "unknown", "best_available"},
    "liveliness": {"system_default", "automatic", "manual_by_topic", "unknown", "best_available"},
}
UNLIMITED = {"sec": 9223372036, "nsec": 854775807}


def copied_by_rosbags(bag: Path, out: Path) -> Path:
    """The bag read and written again by another implementation of rosbag2's format, version 9."""
    with Reader(bag) as reader, RosbagsWriter(out, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        new = {}
        for c in reader.connections:
            new[c.id] = writer.add_connection(
                c.topic,
                c.msgtype,
                msgdef=c.msgdef.data,
                rihs01=c.digest,
                offered_qos_profiles=c.ext.offered_qos_profiles,
            )
        for connection, log_time, data in reader.messages():
            writer.write(new[connection.id], log_time, data)
        for key, text in Bag(bag).facts.items():
            writer.set_custom_data(key, text)
    return out


@pytest.mark.parametrize("name", ["made", "lunch_packing"])
def test_another_writer_of_rosbag2s_format_writes_the_same_metadata_and_channels(
    name: str, made_bag: Path, tmp_path: Path
):
    bag = made_bag if name == "made" else BAGS / name
    ours, theirs = (read_metadata(b) for b in (bag, copied_by_rosbags(bag, tmp_path / bag.name)))
    both = (ours, theirs)
    listed = [{t["topic_metadata"]["name"]: t for t in info.pop("topics_with_message_count")} for info in both]
    assert listed[0] == listed[1]
    files = [info.pop("files") for info in both]
    for info in both:
        # The one thing in which they differ: that of rosbags reports it.
        assert info.pop("ros_distro") in ("jazzy", "rosbags")
        info.pop("relative_file_paths")
    assert ours == theirs
    assert [set(f) for f in files[0]] == [set(f) for f in files[1]]
    channels = []
    for path in (bag, tmp_path / bag.name):
        with next(path.glob("*.mcap")).open("rb") as stream:
            summary = make_reader(stream).get_summary()
        channels.append(
            {
                c.topic: (
                    c.message_encoding,
                    summary.schemas[c.schema_id].name,
                    summary.schemas[c.schema_id].encoding,
                    yaml.safe_load(c.metadata["offered_qos_profiles"]),
                )
                for c in summary.channels.values()
            }
        )
    assert channels[0] == channels[1]


@pytest.mark.parametrize("name", ["made", "stacking_undo"])
def test_metadata_yaml_states_everything_rosbag2_version_9_asks_for(name: str, made_bag: Path):
    bag = made_bag if name == "made" else BAGS / name
    information = read_metadata(bag)
    assert (information["version"], information["storage_identifier"]) == (9, "mcap")
    assert (information["compression_format"], information["compression_mode"]) == ("", "")
    assert information["relative_file_paths"] == [f"{bag.name}_0.mcap"] == [f["path"] for f in information["files"]]
    assert information["ros_distro"] == "jazzy"
    assert information["custom_data"]["session"] == bag.name
    assert all(isinstance(v, str) for pair in information["custom_data"].items() for v in pair)
    assert information["duration"]["nanoseconds"] == Bag(bag).end - Bag(bag).start
    assert information["starting_time"]["nanoseconds_since_epoch"] == Bag(bag).start
    counts = [t["message_count"] for t in information["topics_with_message_count"]]
    assert sum(counts) == information["message_count"] == information["files"][0]["message_count"]
    for entry in information["topics_with_message_count"]:
        topic = entry["topic_metadata"]
        kind = topic["type"]
        # Of the definition in the bag, which for an old one is not today's.
        recorded = Bag(bag).decoder.store(kind).hash_rihs01(kind)
        assert (topic["serialization_format"], topic["type_description_hash"]) == ("cdr", recorded)
        assert name != "made" or recorded == type_hash(kind)
        assert topic["offered_qos_profiles"], topic["name"]
        for profile in topic["offered_qos_profiles"]:
            assert all(profile[policy] in words for policy, words in POLICIES.items())
            assert profile["deadline"] == profile["lifespan"] == profile["liveliness_lease_duration"] == UNLIMITED
            assert profile["avoid_ros_namespace_conventions"] is False
            assert profile["depth"] >= 0


def test_what_nodes_latch_is_latched_for_whoever_plays_the_bag(made_bag: Path):
    facts = ("mapping/estimate", "perception/source_scene", "perception/target_scene", "demonstration/task")
    facts += tuple(f"interaction/{name}" for name in ("state", "prompt", "assists"))
    for path in (made_bag, *(p.parent for p in BAGS.glob("*/metadata.yaml"))):
        bag = Bag(path)
        for name in facts:
            assert {q.durability for q in bag.offered_qos(f"/{name}")} == {"transient_local"}, (path.name, name)


def test_messages_stand_in_chunks_with_indexes_of_all_their_topics(made_bag: Path):
    """Without a message index rosbag2 falls back to the order of the file."""
    for path in (made_bag, BAGS / "sorting"):
        with next(path.glob("*.mcap")).open("rb") as stream:
            summary = make_reader(stream).get_summary()
        assert summary.chunk_indexes
        assert all(c.message_index_length > 0 and c.message_index_offsets for c in summary.chunk_indexes)
        listed = {channel for c in summary.chunk_indexes for channel in c.message_index_offsets}
        assert listed == set(summary.statistics.channel_message_counts)


def test_messages_of_one_topic_and_time_are_found(made_bag: Path):
    bag = Bag(made_bag)
    wanted = [x for x in bag.messages() if x.topic == "/interaction/state" and 11e9 <= x.log_time < 40e9]
    assert list(bag.messages({"/interaction/state"}, 11_000_000_000, 40_000_000_000)) == wanted
    assert wanted
