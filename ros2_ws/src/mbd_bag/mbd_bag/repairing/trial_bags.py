"""Intact bags to be damaged, in both storages, and which bytes of them hold each message."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter

from mbd_bag.errors import BagError
from mbd_bag.formats.contents import BagMessage
from mbd_bag.repairing.sqlite.pages import Pages, open_pages
from mbd_bag.repairing.sqlite.rows import MessageRow, find_rows, follow, record_bytes
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.mcap_file import McapFile

# What no other message of a bag shares, but its copies: topic, when it was recorded [ns], digest of its data.
MessageIdentity = tuple[str, int, bytes]


@dataclass(frozen=True)
class PlacedMessage:
    """One message, and the parts of its file that hold it.

    Attributes:
        identity: of the message.
        size: of its data [byte].
        parts: chunk or pages, first and behind the last byte of each.
    """

    identity: MessageIdentity
    size: int
    parts: frozenset[tuple[int, int]]


@dataclass(frozen=True)
class TrialBag:
    """An intact bag of one file.

    Attributes:
        folder: of the bag.
        file: in it.
        messages: all of them.
        page: size of its pages [byte]; 0 where it has none, but chunks with checksums.
    """

    folder: Path
    file: Path
    messages: tuple[PlacedMessage, ...]
    page: int


def identity_of(message: BagMessage) -> MessageIdentity:
    """What tells a message from others."""
    return message.topic, message.log_time, _digest(message.data)


def _digest(data: bytes) -> bytes:
    return sha256(data).digest()[:12]


@lru_cache(maxsize=16)  # a few bags are damaged over and over
def mcap_bag(folder: Path) -> TrialBag:
    """A bag of one MCAP file, as it lies."""
    files = sorted(folder.glob("*.mcap"))
    if len(files) != 1:
        raise BagError(f"{folder} is no bag of one MCAP file: it holds {len(files)}; give the folder of such a bag")
    (file,) = files
    opened = McapFile(file)
    placed: list[PlacedMessage] = []
    for chunk in sorted(opened.contents.chunks, key=lambda c: c.chunk_start_offset):
        part = frozenset({(chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length)})
        placed += [PlacedMessage(identity_of(m), len(m.data), part) for m in opened.chunk_messages(chunk)]
    return TrialBag(folder, file, tuple(placed), page=0)


@lru_cache(maxsize=16)
def sqlite_bag(folder: Path) -> TrialBag:
    """A bag of one sqlite3 file; raises BagError when sqlite reads other messages than its pages hold."""
    (file,) = folder.glob("*.db3")
    pages = open_pages(file)
    found = find_rows(pages)
    placed: list[PlacedMessage] = []
    for row in found.messages:
        data = (record_bytes(pages, row.leaf, row.cell) or b"")[row.offset :]
        identity = found.topics[row.topic].name, row.time, _digest(data)
        placed.append(PlacedMessage(identity, len(data), _pages_of(pages, row)))
    if Counter(map(identity_of, Bag(file).messages())) != Counter(m.identity for m in placed):
        raise BagError(f"{file}: sqlite reads other messages than its pages hold")
    return TrialBag(folder, file, tuple(placed), pages.size)


def _pages_of(pages: Pages, row: MessageRow) -> frozenset[tuple[int, int]]:
    own = {row.page}
    follow(pages, row.cell, lambda number, _: own.add(number))
    return frozenset(((number - 1) * pages.size, number * pages.size) for number in own)


def as_recorded(bag: Path, out: Path, period: int = 500_000_000) -> Path:
    """A bag as a recorder writes it: its chunks end twice a second [ns]. Returns the folder written.

    Args:
        bag: of any chunks.
        out: folder to write.
        period: after which a chunk ends [ns].
    """
    source = Bag(bag)
    definitions = {s.name: s.data.decode() for f in source.files for s in f.contents.schemas.values()}
    with BagWriter(out) as writer:
        writer.add_facts(source.facts)
        flushed = source.start
        for topic in source.topics:
            if topic.count:
                record = TopicRecord(topic.name, topic.msgtype, qos=source.offered_qos(topic.name))
                writer.add_topic(record, definitions[topic.msgtype])
        for message in source.messages():
            writer.write(message.topic, message.log_time, message.data, message.publish_time)
            if message.log_time - flushed >= period:
                writer.flush()
                flushed = message.log_time
    return out


def as_sqlite(bag: Path, out: Path) -> Path:
    """Store a bag as rosbag2 did by default up to Humble, in one sqlite3 file, by rosbags. Returns the folder.

    Args:
        bag: of any storage.
        out: folder to write; it must not exist.
    """
    source = Bag(bag)
    with RosbagsWriter(out, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            t.name: writer.add_connection(t.name, t.msgtype, typestore=source.decoder.store(t.msgtype))
            for t in source.topics
            if t.count
        }
        for message in source.messages():
            writer.write(connections[message.topic], message.log_time, message.data)
    return out
