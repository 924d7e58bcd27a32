"""The copy of one bag for others, and what is not in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.definitions import type_hash

from mbd_study.sharing.names import NameFinder
from mbd_study.sharing.pictures.cover import CoverCounts, PictureCover, reasons
from mbd_study.sharing.pictures.faces import FaceFinder
from mbd_study.sharing.rules import PICTURES, SharedPictures, shared_facts, why_left_out
from mbd_study.sharing.strings import clean_message, parts_of

_SCENES = ("mbd_msgs/msg/Scene", "mbd_msgs/msg/Task")


@dataclass(frozen=True)
class Omissions:
    """What a copy lacks.

    Attributes:
        topics: (why, number of messages) by topic.
        blanked: number of texts emptied, or in which a name was replaced, by ``Type.field``.
        facts: keys of the facts.
        covered: what was done with its pictures; None when nothing was.
    """

    topics: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    blanked: Mapping[str, int] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
    covered: CoverCounts | None = None


def shared_copy(
    bag: Bag,
    folder: Path,
    *,
    session: str,
    participant: str,
    names: Iterable[str] = (),
    pictures: SharedPictures = SharedPictures.NONE,
) -> Omissions:
    """Write a copy of a bag under new names.

    Args:
        bag: to copy; nothing in it is changed.
        folder: of the copy; it must not exist.
        session: new name.
        participant: new pseudonym.
        names: that must not be read anywhere, besides the bag's own session and participant.
        pictures: what is kept of them.

    Raises:
        BagError: the folder exists, a message cannot be decoded, or nothing of the bag may be kept; pictures are to
            be covered and nothing here finds faces.
    """
    ids = _object_ids(bag)
    # An object's id is no name, though a participant be called s1: it stands in every message.
    finder = NameFinder({bag.facts.get("session", ""), bag.facts.get("participant", ""), *names} - ids)
    why_not = {t.name: _why(t.name, t.msgtype, finder, pictures) for t in bag.topics if t.count}
    cover = _cover(bag, why_not) if pictures is SharedPictures.TABLE else None
    counts = {t.name: t.count for t in bag.topics}
    if "" not in why_not.values():
        raise BagError(f"{bag.path} holds nothing of a session that a copy may keep: another program recorded it")
    facts, dropped = shared_facts(bag.facts, finder)
    changed: dict[str, int] = {}
    with BagWriter(folder, compression=Compression.ZSTD) as copy:
        copy.add_facts(facts | {"session": session, "participant": participant, "shared": "copy without personal data"})
        for topic in bag.topics:
            if why_not.get(topic.name) == "":
                record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), bag.offered_qos(topic.name))
                copy.add_topic(record, bag.decoder.texts[topic.msgtype])
        for recorded in bag.messages({name for name, why in why_not.items() if not why}):
            message = recorded
            if cover is not None and message.msgtype in PICTURES:
                shown = cover.covered(bag, message)
                if shown is None:
                    continue
                message = replace(message, data=shown)
            data = bytes(message.data)
            if message.msgtype.startswith("mbd_msgs/") or finder.maybe_in(data):
                decoded = bag.decoder.decode(message)
                clean_message(decoded, session=session, ids=ids, names=finder, changed=changed)
                data = bag.decoder.encode(decoded, message.msgtype)
            copy.write(message.topic, message.log_time, data, message.publish_time)
    topics = {finder.without(name): (why, counts[name]) for name, why in why_not.items() if why}
    if cover is not None:
        topics |= {finder.without(name): left_out for name, left_out in reasons(cover.counts.left_out).items()}
    return Omissions(topics, changed, dropped, None if cover is None else cover.counts)


def _cover(bag: Bag, why_not: dict[str, str]) -> PictureCover | None:
    """What covers the pictures that would be kept; where nothing can, they are left out by ``why_not``."""
    kept = {t.name for t in bag.topics if why_not.get(t.name) == "" and t.msgtype in PICTURES}
    if not kept:
        return None
    cover = PictureCover(bag, frozenset(kept), FaceFinder())
    if cover.why_none:
        why_not.update(dict.fromkeys(kept, cover.why_none))
    return cover


def _why(topic: str, msgtype: str, names: NameFinder, pictures: SharedPictures) -> str:
    """Why a topic is left out; "" when it is not."""
    if names.within(topic):
        return "its topic holds a name"
    return why_left_out(msgtype, pictures)


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
