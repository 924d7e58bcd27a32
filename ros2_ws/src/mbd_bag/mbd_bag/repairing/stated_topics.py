"""Topics whose declaration is damaged, by what metadata.yaml states of the bag.

A file declares a topic once, in the chunk of its first message. Where that chunk is damaged, and the index is, too, the
messages of all later chunks have a number and no name. metadata.yaml has names, types and numbers of messages. It is
believed where it leaves one answer only, and where every message is one of that type.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import raw_message
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.known_definitions import known_definition
from mbd_bag.repairing.intact_records import IntactRecords, chunk_at
from mbd_bag.storage.bag_metadata import read_metadata
from mbd_bag.storage.decoding import Decoder

_ALIKE = 0.5  # share of a damaged definition that must be as in the one known here
_WITNESSES = 3  # topics and types that must be where they are by the order of metadata.yaml


@dataclass(frozen=True)
class StatedTopic:
    """A topic of metadata.yaml: its name, type, and number of messages."""

    name: str
    msgtype: str
    count: int


def stated_topics(bag: Path) -> tuple[StatedTopic, ...]:
    """The topics that a bag's metadata.yaml lists, in its order; () when it cannot be read."""
    try:
        listed = read_metadata(bag)["topics_with_message_count"]
        return tuple(
            StatedTopic(str(t["topic_metadata"]["name"]), str(t["topic_metadata"]["type"]), int(t["message_count"]))
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


def _schema(found: IntactRecords, kind: str) -> Schema | None:
    """The definition of a type: the file's own, else the one known here."""
    own = next((s for s in found.schemas.values() if s.name == kind), None)
    if own is not None:
        return own
    encoding, text = known_definition(kind)
    return Schema(0, text.encode(), encoding, kind) if text else None


def _declare(found: IntactRecords, number: int, topic: StatedTopic) -> None:
    schema = _schema(found, topic.msgtype)
    if schema is None:
        return
    if schema.id == 0:
        # A number that no declaration of the file has, also none that is damaged.
        known = {*found.schemas, *(s.id for s in found.doubtful_schemas)}
        schema = Schema(max(known, default=0) + 1, schema.data, schema.encoding, schema.name)
        found.schemas[schema.id] = schema
    found.channels[number] = Channel(number, topic.name, "cdr", {}, schema.id)


def _all_decode(view: memoryview, found: IntactRecords, number: int, topic: StatedTopic) -> bool:
    """Whether every message of a channel is one of a topic's type."""
    schema = _schema(found, topic.msgtype)
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
