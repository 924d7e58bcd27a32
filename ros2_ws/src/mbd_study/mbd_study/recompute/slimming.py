"""A small copy of a session: of its pictures only those a scene was made of, so that it still computes from clouds."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.images.image_cdr import COMPRESSED_IMAGE, IMAGE
from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.session.session_facts import recorded_parameters
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.definitions import type_hash
from mbd_perception.parameters import PERCEPTION

from mbd_study.recompute.reperception import SAME_MOMENT

_PICTURES = (IMAGE, COMPRESSED_IMAGE, "sensor_msgs/msg/CameraInfo")


def observed_stamps(bag: Bag, session: RecordedSession) -> dict[str, frozenset[int]]:
    """Of each picture topic the stamps [ns] that a scene was made of: the last frames up to the scene's own stamp."""
    count = PERCEPTION.values(recorded_parameters(session.facts, PERCEPTION))["frames"]
    stamps: dict[str, set[int]] = {t.name: set() for t in bag.topics if t.msgtype in _PICTURES}
    for message in bag.messages(set(stamps)):
        stamps[message.topic].add(header_stamp(message.data))
    scenes = [s.stamp for s in (*session.source_scenes, *session.target_scenes)]
    return {
        topic: frozenset(s for scene in scenes for s in sorted(t for t in found if t <= scene + SAME_MOMENT)[-count:])
        for topic, found in stamps.items()
    }


def slim_copy(bag: Bag, session: RecordedSession, folder: Path) -> None:
    """Write the copy.

    Args:
        bag: to copy.
        session: as read from it.
        folder: of the copy; it must not exist.

    Raises:
        BagError: it exists.
    """
    observed = observed_stamps(bag, session)
    with BagWriter(folder, compression=Compression.ZSTD) as copy:
        copy.add_facts(dict(bag.facts) | {"slimmed": "pictures only of the moments observed"})
        for topic in bag.topics:
            if topic.count:
                record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), bag.offered_qos(topic.name))
                copy.add_topic(record, bag.decoder.texts[topic.msgtype])
        for message in bag.messages():
            if message.topic not in observed or header_stamp(message.data) in observed[message.topic]:
                copy.write(message.topic, message.log_time, message.data, message.publish_time)
