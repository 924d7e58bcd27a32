"""Topics whose declaration is damaged, by what metadata.yaml states of the bag.

A file declares a topic once, in the chunk of its first message. Where that chunk is damaged, and the index is, too, the
messages of all later chunks have a number and no name. metadata.yaml has names, types and numbers of messages. It is
believed where it leaves one answer only, and where every message is one of that type.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import raw_message
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.known_definitions import known_definition
from mbd_bag.repairing.intact_records import IntactRecords, chunk_at
from mbd_bag.repairing.partial_chunk import definition_hash, makes_sense
from mbd_bag.storage.bag_metadata import read_metadata
from mbd_bag.storage.decoding import Decoder

_ALIKE = 0.5  # share of a damaged definition that must be as in the one known here
_WITNESSES = 3  # topics and types that must be where they are by the order of metadata.yaml


@dataclass(frozen=True)
class StatedTopic:
    """A topic of metadata.yaml: its name, type, number of messages, and its type's hash ("" where it states none)."""

    name: str
    msgtype: str
    count: int
    type_hash: str = ""


def stated_topics(bag: Path) -> tuple[StatedTopic, ...]:
    """The topics that a bag's metadata.yaml lists, in its order; () when it cannot be read."""
    try:
        listed = read_metadata(bag)["topics_with_message_count"]
        return tuple(
            StatedTopic(
                str(t["topic_metadata"]["name"]),
                str(t["topic_metadata"]["type"]),
                int(t["message_count"]),
                str(t["topic_metadata"].get("type_description_hash") or ""),
            )
            for t in listed
        )
    except (BagError, KeyError, TypeError, ValueError):
        return ()


def complete_declarations(view: memoryview, found: IntactRecords, stated: tuple[StatedTopic, ...]) -> None:
    """Add the declarations that are damaged in a file and can be had from elsewhere.

    Args:
        view: of the file's bytes.
        found: in it; changed.
        stated: by metadata.yaml; () when it states nothing, or of several files together.
    """
    used = _used(view, found)
    if used.keys() <= found.channels.keys():
        return
    types = {t.name: t.msgtype for t in stated}
    for channel in found.doubtful_channels:
        damaged = next((s for s in found.doubtful_schemas if s.id == channel.schema_id), None)
        if channel.id in found.channels or damaged is None or types.get(channel.topic, "") != damaged.name:
            continue
        if _alike(damaged, _schema(found, damaged.name)):
            _declare(found, channel.id, StatedTopic(channel.topic, damaged.name, 0))
    _take_index(view, found, stated, used)
    missing = used.keys() - found.channels.keys()
    names = {c.topic for c in found.channels.values()}
    left = [t for t in stated if t.name not in names and t.count]
    counted = found.indexed.total() == sum(t.count for t in stated)
    for number in sorted(missing) if counted else ():
        # The message indexes list all messages of the bag: a topic has as many as its channel.
        fitting = [t for t in left if t.count == found.indexed[number] and _all_decode(view, found, number, t)]
        if len(fitting) == 1:
            _declare(found, number, fitting[0])
    missing -= found.channels.keys()
    for number, topic in _by_order(view, found, stated, missing).items():
        if topic.count >= used[number]:
            _declare(found, number, topic)


def _used(view: memoryview, found: IntactRecords) -> Counter[int]:
    """Messages of intact chunks by channel id."""
    counts: Counter[int] = Counter()
    for offset in found.chunks:
        counts.update(chunk_at(view, offset).ids)
    return counts


def _take_index(
    view: memoryview, found: IntactRecords, stated: tuple[StatedTopic, ...], used: Mapping[int, int]
) -> None:
    """Take from an index whose checksum is wrong what metadata.yaml states, too.

    That is a topic's name and type, and a definition by its hash: a byte of a definition that was changed changes it,
    unless it lies in a comment.
    """
    hashes = {t.msgtype: t.type_hash for t in stated if t.type_hash}
    for schema in found.index_schemas:
        own = any(s.name == schema.name for s in found.schemas.values())
        if not own and makes_sense(schema) and definition_hash(schema) == hashes.get(schema.name):
            _add_schema(found, schema)
    topics = {t.name: t for t in stated}
    names = {c.topic for c in found.channels.values()}
    claims = Counter(claim for c in found.index_channels for claim in (c.id, c.topic))
    for channel in found.index_channels:
        topic = topics.get(channel.topic)
        if topic is None or channel.topic in names or channel.id in found.channels:
            continue
        if claims[channel.id] > 1 or claims[channel.topic] > 1:
            continue
        if topic.count >= used.get(channel.id, 0) and _all_decode(view, found, channel.id, topic):
            _declare(found, channel.id, topic)


def _by_order(
    view: memoryview, found: IntactRecords, stated: tuple[StatedTopic, ...], missing: Collection[int]
) -> dict[int, StatedTopic]:
    """The topics at the channels' places in metadata.yaml, when these are in that order.

    They are when all that are known stand at theirs, when most of the others have messages of the type at theirs, and
    both together are enough to be no chance.
    """
    places = {k + 1: t for k, t in enumerate(stated)}
    if any(k not in places or places[k].name != c.topic for k, c in found.channels.items()):
        return {}
    fitting = {n: places[n] for n in sorted(missing) if n in places and _all_decode(view, found, n, places[n])}
    witnesses = len(found.channels) + len({t.msgtype for t in fitting.values()})
    return fitting if witnesses >= _WITNESSES and 2 * len(fitting) > len(missing) else {}


def _alike(damaged: Schema, known: Schema | None) -> bool:
    """Whether a damaged definition was the one that is known here."""
    if known is None or len(known.data) != len(damaged.data):
        return False
    same = sum(a == b for a, b in zip(known.data, damaged.data, strict=True))
    return same >= _ALIKE * len(known.data)


def _schema(found: IntactRecords, kind: str, stated_hash: str = "") -> Schema | None:
    """The definition of a type: the file's own, else the one known here, if it has the hash that is stated."""
    own = next((s for s in found.schemas.values() if s.name == kind), None)
    if own is not None:
        return own
    encoding, text = known_definition(kind)
    known = Schema(0, text.encode(), encoding, kind)
    return known if text and stated_hash in ("", definition_hash(known)) else None


def _declare(found: IntactRecords, number: int, topic: StatedTopic) -> None:
    schema = _schema(found, topic.msgtype, topic.type_hash)
    if schema is None:
        return
    if schema.id == 0:
        schema = _add_schema(found, schema)
    found.channels[number] = Channel(number, topic.name, "cdr", {}, schema.id)


def _add_schema(found: IntactRecords, schema: Schema) -> Schema:
    """Add it under a number that no declaration of the file has, also none that is damaged."""
    known = {*found.schemas, *(s.id for s in (*found.doubtful_schemas, *found.index_schemas))}
    added = Schema(max(known, default=0) + 1, schema.data, schema.encoding, schema.name)
    found.schemas[added.id] = added
    return added


def _all_decode(view: memoryview, found: IntactRecords, number: int, topic: StatedTopic) -> bool:
    """Whether every message of a channel is one of a topic's type."""
    schema = _schema(found, topic.msgtype, topic.type_hash)
    if schema is None:
        return False
    decoder = Decoder([schema])
    try:
        for offset in found.chunks:
            chunk = chunk_at(view, offset)
            for channel, place in zip(chunk.ids, chunk.offsets, strict=True):
                if channel == number:
                    raw = raw_message(chunk.data, place)
                    decoder.decode(BagMessage(topic.name, topic.msgtype, 0, 0, raw.data))
    except BagError:
        return False
    return True
