"""The copy of one bag for others, and what is not in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mbd_bag.formats.contents import BagMessage
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.definitions import type_hash

from mbd_study.sharing.rules import FREE_TEXT, NAMES, shared_facts, why_left_out


@dataclass(frozen=True)
class Omissions:
    """What a copy lacks.

    Attributes:
        topics: (why, number of messages) by topic.
        blanked: number of texts emptied, by ``Type.field``.
        facts: keys of the facts.
    """

    topics: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    blanked: Mapping[str, int] = field(default_factory=dict)
    facts: tuple[str, ...] = ()


def shared_copy(bag: Bag, folder: Path, *, session: str, participant: str, cameras: bool = False) -> Omissions:
    """Write a copy of a bag under new names.

    Args:
        bag: to copy; nothing in it is changed.
        folder: of the copy; it must not exist.
        session: new name.
        participant: new pseudonym.
        cameras: keep the pictures.

    Raises:
        BagError: the folder exists, or a message that names the session cannot be decoded.
    """
    reasons = {t.name: why_left_out(t.msgtype, cameras) for t in bag.topics if t.count}
    counts = {t.name: t.count for t in bag.topics}
    facts, dropped = shared_facts(bag.facts, (bag.facts.get("session", ""), bag.facts.get("participant", "")))
    blanked: dict[str, int] = {}
    with BagWriter(folder, compression=Compression.ZSTD) as copy:
        copy.add_facts(facts | {"session": session, "participant": participant, "shared": "copy without personal data"})
        for topic in bag.topics:
            if reasons.get(topic.name) == "":
                record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), bag.offered_qos(topic.name))
                copy.add_topic(record, bag.decoder.texts[topic.msgtype])
        for message in bag.messages({name for name, why in reasons.items() if not why}):
            data = _without_names(bag, message, session, blanked)
            copy.write(message.topic, message.log_time, data, message.publish_time)
    return Omissions(
        topics={name: (why, counts[name]) for name, why in reasons.items() if why},
        blanked=blanked,
        facts=dropped,
    )


def _without_names(bag: Bag, message: BagMessage, session: str, blanked: dict[str, int]) -> bytes:
    """The bytes of a message with the new name and without a person's words; counts what was emptied."""
    kind = message.msgtype
    if kind not in NAMES and kind not in FREE_TEXT:
        return bytes(message.data)
    decoded = bag.decoder.decode(message)
    if kind in NAMES and hasattr(decoded, NAMES[kind]):
        setattr(decoded, NAMES[kind], session)
    text = FREE_TEXT.get(kind, "")
    if text and getattr(decoded, text, ""):
        setattr(decoded, text, "")
        key = f"{kind.rpartition('/')[2]}.{text}"
        blanked[key] = blanked.get(key, 0) + 1
    return bag.decoder.encode(decoded, kind)
