"""Finish a bag whose recorder died: what a closed one has and it lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mbd_bag.storage.bag_metadata import FileRecord, TopicRecord, write_metadata
from mbd_bag.storage.bag_writer import records_of
from mbd_bag.storage.mcap_completion import complete


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
