"""A bag's metadata.yaml, version 9 of rosbag2 (Jazzy)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from mbd_bag.errors import BagError
from mbd_bag.formats.bounded_yaml import bounded_yaml
from mbd_bag.storage.topic_qos import TopicQos

FILE_NAME = "metadata.yaml"
VERSION = 9


@dataclass(frozen=True)
class TopicRecord:
    """One topic as metadata.yaml lists it.

    Attributes:
        name: absolute topic name.
        msgtype: ``package/msg/Type``.
        type_hash: REP-2011 hash of the type.
        qos: profiles its publishers offered.
        form: how its messages are serialized.
    """

    name: str
    msgtype: str
    type_hash: str = ""
    qos: tuple[TopicQos, ...] = ()
    form: str = "cdr"


@dataclass(frozen=True)
class FileRecord:
    """One file as metadata.yaml lists it.

    Attributes:
        name: file name inside the bag's folder.
        start, end: log times of its first and last message [ns]; 0 when it has none.
        counts: messages by topic.
    """

    name: str
    start: int
    end: int
    counts: Mapping[str, int]

    @property
    def message_count(self) -> int:
        """Messages of all topics."""
        return sum(self.counts.values())


def _span(files: Sequence[FileRecord]) -> tuple[int, int]:
    filled = [f for f in files if f.message_count]
    if not filled:
        return 0, 0
    start = min(f.start for f in filled)
    return start, max(f.end for f in filled) - start


def _times(files: Sequence[FileRecord]) -> dict[str, dict[str, int]]:
    start, duration = _span(files)
    return {"starting_time": {"nanoseconds_since_epoch": start}, "duration": {"nanoseconds": duration}}


def write_metadata(
    folder: Path, topics: Sequence[TopicRecord], files: Sequence[FileRecord], custom: Mapping[str, str], distro: str
) -> None:
    """Write metadata.yaml at once: there is the complete file or none.

    Args:
        folder: the bag.
        topics: every topic of the bag.
        files: its files in the order recorded.
        custom: session facts, kept as rosbag2's custom_data.
        distro: name of the ROS distribution.
    """
    counts = {t.name: sum(f.counts.get(t.name, 0) for f in files) for t in topics}
    information = {
        "version": VERSION,
        "storage_identifier": "mcap",
        **_times(files),
        "message_count": sum(f.message_count for f in files),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": t.name,
                    "type": t.msgtype,
                    "serialization_format": t.form,
                    "offered_qos_profiles": [q.as_rosbag2() for q in t.qos],
                    "type_description_hash": t.type_hash,
                },
                "message_count": counts[t.name],
            }
            for t in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [f.name for f in files],
        "files": [{"path": f.name, **_times([f]), "message_count": f.message_count} for f in files],
        "custom_data": dict(custom),
        "ros_distro": distro,
    }
    part = folder / f".{FILE_NAME}.part"
    with part.open("w", encoding="utf-8") as stream:
        yaml.safe_dump({"rosbag2_bagfile_information": information}, stream, sort_keys=False, width=1000)
        stream.flush()
        os.fsync(stream.fileno())
    part.replace(folder / FILE_NAME)


def read_metadata(folder: Path) -> dict[str, Any]:
    """What metadata.yaml states, each part of its kind; raises BagError when it is not what rosbag2 writes."""
    path = folder / FILE_NAME
    try:
        information = bounded_yaml(path.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        stated = {**information, "storage_identifier": str(information["storage_identifier"])}
        stated["relative_file_paths"] = [Path(str(n)).name for n in _listed(information["relative_file_paths"])]
        stated["custom_data"] = {str(k): str(v) for k, v in dict(information.get("custom_data") or {}).items()}
        stated["compression_mode"] = str(information.get("compression_mode") or "").lower()
        stated["message_count"] = int(information.get("message_count", -1))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BagError(
            f"{path} is not what rosbag2 writes ({error}); remove it to read the bag's files alone"
        ) from error
    return stated


def _listed(value: Any) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise ValueError(f"relative_file_paths is {str(value)[:80]!r}; expected a list of files")
    return value
