"""MCAP's conformance suite, written from its descriptions (foxglove/mcap, tests/conformance, MIT licence).

The suite's files lie in Git LFS; what can be had everywhere are their descriptions and their SHA-256. Each file is one
of six contents, written with a combination of the format's optional parts. `suite` writes all of them, byte for byte as
they are in the suite: mcap_suite_digests.txt has the first 16 digits of each file's SHA-256.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from zlib import crc32

from mcap.records import Attachment, Channel, Message, Metadata, Schema

MAGIC = b"\x89MCAP0\r\n"
FEATURES = ("ch", "mx", "st", "rsh", "rch", "ax", "mdx", "chx", "sum", "pad")
DIGESTS = Path(__file__).with_suffix("").with_name("mcap_suite_digests.txt")
Described = Schema | Channel | Message | Attachment | Metadata

_SCHEMA = Schema(id=1, name="Example", encoding="c", data=b"\4\5\6")
_CHANNEL = Channel(id=1, topic="example", message_encoding="a", metadata={"foo": "bar"}, schema_id=1)
_SCHEMALESS = Channel(id=1, topic="example", message_encoding="text", metadata={}, schema_id=0)
_MESSAGE = Message(channel_id=1, sequence=10, log_time=2, publish_time=1, data=b"\1\2\3")
CONTENTS: dict[str, tuple[Described, ...]] = {
    "NoData": (),
    "OneSchemalessMessage": (_SCHEMALESS, _MESSAGE),
    "OneMessage": (_SCHEMA, _CHANNEL, _MESSAGE),
    "OneAttachment": (
        Attachment(name="myFile", media_type="application/octet-stream", log_time=2, create_time=1, data=b"\1\2\3"),
    ),
    "OneMetadata": (Metadata(name="myMetadata", metadata={"foo": "bar"}),),
    "TenMessages": (
        _SCHEMA,
        _CHANNEL,
        *(
            Message(channel_id=1, sequence=k, log_time=time, publish_time=time, data=b"\1\2\3")
            for k, time in enumerate((0, 2, 1, 3, 3, 5, 4, 7, 8, 9))
        ),
    ),
}


@dataclass(frozen=True)
class SuiteFile:
    """One file of the suite.

    Attributes:
        name: as the suite names it.
        records: what it describes.
        features: which optional parts it has.
        data: its bytes.
    """

    name: str
    records: tuple[Described, ...]
    features: frozenset[str]
    data: bytes


def suite() -> Iterator[SuiteFile]:
    """Every file of the suite."""
    for (name, records), chosen in product(CONTENTS.items(), product((False, True), repeat=len(FEATURES))):
        features = frozenset(f for f, taken in zip(FEATURES, chosen, strict=True) if taken)
        if _makes_sense(records, features):
            full = "-".join((name, *sorted(features)))
            yield SuiteFile(full, records, features, _file(records, features))


def _makes_sense(records: tuple[Described, ...], features: frozenset[str]) -> bool:
    """As the suite's own generator chooses."""
    kinds = {type(r) for r in records}
    needs = {"ax": {Attachment}, "mdx": {Metadata}, "rsh": {Schema}, "rch": {Channel}}
    needs |= {f: {Message, Channel, Schema} for f in ("ch", "chx", "mx")}
    return (
        all(not features & {f} or kinds & needed for f, needed in needs.items())
        and ("sum" not in features or bool(features & {"chx", "rsh", "rch", "mdx", "ax", "st"}))
        and ("ch" in features or not features & {"chx", "mx"})
    )


def _text(text: str | bytes) -> bytes:
    data = text.encode() if isinstance(text, str) else text
    return struct.pack("<I", len(data)) + data


def _pairs(pairs: dict[str, str]) -> bytes:
    return _text(b"".join(_text(k) + _text(v) for k, v in pairs.items()))


def _record(opcode: int, body: bytes, pad: bool = False) -> bytes:
    body += b"\x01\xff\xff" * pad
    return struct.pack("<BQ", opcode, len(body)) + body


def _described(record: Described, pad: bool) -> bytes:
    """One record of the data section."""
    match record:
        case Schema():
            head = struct.pack("<H", record.id) + _text(record.name) + _text(record.encoding)
            return _record(3, head + _text(record.data), pad)
        case Channel():
            head = struct.pack("<HH", record.id, record.schema_id) + _text(record.topic)
            return _record(4, head + _text(record.message_encoding) + _pairs(record.metadata), pad)
        case Message():
            head = struct.pack("<HIQQ", record.channel_id, record.sequence, record.log_time, record.publish_time)
            return _record(5, head + record.data)
        case Attachment():
            head = struct.pack("<QQ", record.log_time, record.create_time) + _text(record.name)
            body = head + _text(record.media_type) + struct.pack("<Q", len(record.data)) + record.data
            return _record(9, body + struct.pack("<I", crc32(body)), pad)
        case Metadata():
            return _record(12, _text(record.name) + _pairs(record.metadata), pad)


@dataclass
class _Data:
    """The data section: its bytes so far, and the indexes of what lies in it by kind of record."""

    out: bytearray
    indexes: dict[int, list[bytes]] = field(default_factory=lambda: {13: [], 10: [], 8: []})


def _file(records: tuple[Described, ...], features: frozenset[str]) -> bytes:
    pad = "pad" in features
    data = _Data(bytearray(MAGIC + _record(1, _text("") * 2, pad)))
    inner: list[Described] = []
    for record in records:
        if "ch" in features and isinstance(record, Schema | Channel | Message):
            inner.append(record)
            continue
        offset, written = len(data.out), _described(record, pad)
        data.out += written
        place = struct.pack("<QQ", offset, len(written))
        if isinstance(record, Attachment) and "ax" in features:
            times = struct.pack("<QQQ", record.log_time, record.create_time, len(record.data))
            data.indexes[10].append(place + times + _text(record.name) + _text(record.media_type))
        if isinstance(record, Metadata) and "mdx" in features:
            data.indexes[13].append(place + _text(record.name))
    if "ch" in features:
        _chunk(data, inner, features)
    data.out += _record(15, struct.pack("<I", crc32(data.out)))
    return bytes(data.out + _ending(data, records, features))


def _chunk(data: _Data, inner: list[Described], features: frozenset[str]) -> None:
    body, listed = bytearray(), dict[int, list[tuple[int, int]]]()
    for record in inner:
        if isinstance(record, Channel):
            listed.setdefault(record.id, [])
        if isinstance(record, Message):
            listed.setdefault(record.channel_id, []).append((record.log_time, len(body)))
        body += _described(record, False)
    times = _times(inner)
    start = len(data.out)
    head = struct.pack("<QQQI", *times, len(body), crc32(body)) + _text("")
    data.out += _record(6, head + struct.pack("<Q", len(body)) + body)
    end = len(data.out)
    offsets = b""
    for channel, entries in listed.items() if "mx" in features else ():
        offsets += struct.pack("<HQ", channel, len(data.out))
        rows = b"".join(struct.pack("<QQ", *entry) for entry in entries)
        data.out += _record(7, struct.pack("<H", channel) + _text(rows), "pad" in features)
    if "chx" in features:
        place = struct.pack("<QQQQ", *times, start, end - start) + _text(offsets)
        lengths = struct.pack("<Q", len(data.out) - end) + _text("") + struct.pack("<QQ", len(body), len(body))
        data.indexes[8].append(place + lengths)


def _times(records: list[Described] | tuple[Described, ...]) -> tuple[int, int]:
    times = [r.log_time for r in records if isinstance(r, Message)] or [0]
    return min(times), max(times)


def _statistics(records: tuple[Described, ...], features: frozenset[str]) -> bytes:
    def count(kind: type) -> int:
        return sum(isinstance(r, kind) for r in records)

    numbers = (count(Message), count(Schema), count(Channel), count(Attachment), count(Metadata), "ch" in features)
    by_channel = struct.pack("<HQ", 1, count(Message)) if count(Message) else b""
    return struct.pack("<QHIIIIQQ", *numbers, *_times(records)) + _text(by_channel)


def _ending(data: _Data, records: tuple[Described, ...], features: frozenset[str]) -> bytes:
    """Summary, footer and magic."""
    pad, start = "pad" in features, len(data.out)
    groups: list[tuple[int, bytes]] = []
    repeated: tuple[tuple[str, int, Callable[[Described], bool]], ...] = (
        ("rsh", 3, lambda r: isinstance(r, Schema)),
        ("rch", 4, lambda r: isinstance(r, Channel)),
    )
    for feature, opcode, taken in repeated:
        if feature in features:
            groups.append((opcode, b"".join(_described(r, pad) for r in records if taken(r))))
    if "st" in features:
        groups.append((11, _record(11, _statistics(records, features), pad)))
    groups += [(kind, b"".join(_record(kind, body, pad) for body in data.indexes[kind])) for kind in (13, 10, 8)]
    groups = [(opcode, body) for opcode, body in groups if body]
    summary, offsets = b"".join(body for _, body in groups), b""
    at = start
    for opcode, body in groups:
        offsets += _record(14, struct.pack("<BQQ", opcode, at, len(body)), pad)
        at += len(body)
    offsets = offsets if "sum" in features else b""
    foot = struct.pack("<QQ", start if summary else 0, at if "sum" in features else 0)
    checksum = crc32(summary + offsets + struct.pack("<BQ", 2, 20) + foot)
    return summary + offsets + _record(2, foot + struct.pack("<I", checksum)) + MAGIC
