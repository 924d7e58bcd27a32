"""Finish a bag whose recorder died: what a closed one has and it lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mbd_bag.storage.bag_metadata import FileRecord, TopicRecord, write_metadata
from mbd_bag.storage.mcap_completion import complete
from mbd_bag.storage.mcap_file import McapFile
from mbd_bag.storage.topic_qos import from_yaml

FACTS_RECORD = "mbd_session"


def records_of(file: McapFile) -> tuple[list[TopicRecord], dict[str, str], FileRecord]:
    """What metadata.yaml states of one file: its topics, its facts, its span and counts."""
    contents = file.contents
    topics = [
        TopicRecord(
            channel.topic,
            contents.schemas[channel.schema_id].name,
            channel.metadata.get("topic_type_hash", ""),
            from_yaml(channel.metadata.get("offered_qos_profiles", "")),
            channel.message_encoding,
        )
        for channel in contents.channels.values()
    ]
    facts: dict[str, str] = {}
    for record, _ in contents.metadata:
        if record.name == FACTS_RECORD:
            facts |= record.metadata
    return topics, facts, FileRecord(file.path.name, contents.start, contents.end, contents.topic_counts())


def finish(folder: Path, files: Sequence[Path], facts: Mapping[str, str], distro: str = "jazzy") -> None:
    """Give each file the end it lacks, and the bag its metadata.yaml.

    Args:
        folder: the bag.
        files: its files in the order recorded; those that are complete stay as they are.
        facts: to add to the bag, besides those in its files.
        distro: name of the ROS distribution.

    Raises:
        BagError: a file cannot be read at all.
    """
    topics: dict[str, TopicRecord] = {}
    kept: dict[str, str] = {}
    records: list[FileRecord] = []
    for path in files:
        of_file, more_facts, record = records_of(complete(path))
        topics |= {t.name: t for t in of_file}
        kept |= more_facts
        records.append(record)
    write_metadata(folder, [topics[n] for n in sorted(topics)], records, kept | dict(facts), distro)
