"""The copy of one bag for others, and what is not in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.definitions import type_hash

from mbd_study.sharing.names import NameFinder
from mbd_study.sharing.rules import shared_facts, why_left_out
from mbd_study.sharing.strings import clean_message, parts_of

_SCENES = ("mbd_msgs/msg/Scene", "mbd_msgs/msg/Task")


@dataclass(frozen=True)
class Omissions:
    """What a copy lacks.

    Attributes:
        topics: (why, number of messages) by topic.
        blanked: number of texts emptied, or in which a name was replaced, by ``Type.field``.
        facts: keys of the facts.
    """

    topics: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    blanked: Mapping[str, int] = field(default_factory=dict)
    facts: tuple[str, ...] = ()


def shared_copy(
    bag: Bag, folder: Path, *, session: str, participant: str, names: Iterable[str] = (), cameras: bool = False
) -> Omissions:
    """Write a copy of a bag under new names.

    Args:
        bag: to copy; nothing in it is changed.
        folder: of the copy; it must not exist.
        session: new name.
        participant: new pseudonym.
        names: that must not be read anywhere, besides the bag's own session and participant.
        cameras: keep the pictures.

    Raises:
        BagError: the folder exists, a message cannot be decoded, or nothing of the bag may be kept.
    """
    ids = _object_ids(bag)
    # An object's id is no name, though a participant be called s1: it stands in every message.
    finder = NameFinder({bag.facts.get("session", ""), bag.facts.get("participant", ""), *names} - ids)
    reasons = {t.name: _why(t.name, t.msgtype, finder, cameras) for t in bag.topics if t.count}
    counts = {t.name: t.count for t in bag.topics}
    if "" not in reasons.values():
        raise BagError(f"{bag.path} holds nothing of a session that a copy may keep: another program recorded it")
    facts, dropped = shared_facts(bag.facts, finder)
    changed: dict[str, int] = {}
    with BagWriter(folder, compression=Compression.ZSTD) as copy:
        copy.add_facts(facts | {"session": session, "participant": participant, "shared": "copy without personal data"})
        for topic in bag.topics:
            if reasons.get(topic.name) == "":
                record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), bag.offered_qos(topic.name))
                copy.add_topic(record, bag.decoder.texts[topic.msgtype])
        for message in bag.messages({name for name, why in reasons.items() if not why}):
            data = bytes(message.data)
            if message.msgtype.startswith("mbd_msgs/") or finder.maybe_in(data):
                decoded = bag.decoder.decode(message)
                clean_message(decoded, session=session, ids=ids, names=finder, changed=changed)
                data = bag.decoder.encode(decoded, message.msgtype)
            copy.write(message.topic, message.log_time, data, message.publish_time)
    return Omissions(
        topics={finder.without(name): (why, counts[name]) for name, why in reasons.items() if why},
        blanked=changed,
        facts=dropped,
    )


def _why(topic: str, msgtype: str, names: NameFinder, cameras: bool) -> str:
    """Why a topic is left out; "" when it is not."""
    if names.within(topic):
        return "its topic holds a name"
    return why_left_out(msgtype, cameras)


def _object_ids(bag: Bag) -> frozenset[str]:
    """The ids that perception gave to objects, by what it published."""
    topics = {t.name for t in bag.topics if t.count and t.msgtype in _SCENES}
    found = {
        str(part.id)
        for _, message in (bag.decoded(topics) if topics else ())
        for part in parts_of(message)
        if getattr(part, "__msgtype__", "") == "mbd_msgs/msg/ObjectFeatures"
    }
    return frozenset(found)
