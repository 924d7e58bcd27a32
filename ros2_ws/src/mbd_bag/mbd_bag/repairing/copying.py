"""Write what is intact in a file into a new one."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from mbd_bag.formats.chunks import RawMessage, raw_message
from mbd_bag.repairing.intact_records import IntactRecords, chunk_at, intact_records
from mbd_bag.repairing.stated_topics import StatedTopic, complete_declarations
from mbd_bag.storage.mcap_file import LIBRARY
from mbd_bag.storage.record_file import RecordFile
from mbd_bag.storage.topic_qos import as_yaml, from_yaml

_COMPRESSIONS = {"": CompressionType.NONE, "lz4": CompressionType.LZ4, "zstd": CompressionType.ZSTD}


@dataclass(frozen=True)
class Copied:
    """What became of one file.

    Attributes:
        kept: messages in the copy.
        undeclared: messages of intact chunks whose channel is not declared in any intact place, and so are left out.
        damaged: bytes that could not be read.
        damages: places at which something could not be read.
    """

    kept: int
    undeclared: int
    damaged: int
    damages: int

    def sentences(self, name: str) -> tuple[str, ...]:
        """What was kept and lost of a file of this name, for people."""
        lost = (
            f"{self.damaged} bytes at {self.damages} places could not be read" if self.damages else "nothing was lost"
        )
        left_out = f", and {self.undeclared} messages whose topic is not known are left out" if self.undeclared else ""
        return (f"{name}: {self.kept} messages kept; {lost}{left_out}",)


def copy_intact(source: Path, out: Path, stated: tuple[StatedTopic, ...] = ()) -> Copied:
    """Copy all that is intact in an MCAP file; the file itself is only read.

    Args:
        source: the damaged file.
        out: to write; it must not exist.
        stated: the topics of its bag by metadata.yaml, where the file is the only one of it.

    Raises:
        OSError: it exists, or the disk is full.
    """
    with source.open("rb") as stream:
        empty = not source.stat().st_size
        data = memoryview(b"" if empty else mmap.mmap(stream.fileno(), 0, prot=mmap.PROT_READ))
    found = intact_records(data)
    complete_declarations(data, found, stated)
    file = RecordFile(out)
    writer = McapWriter(cast(IO[bytes], file), compression=_COMPRESSIONS[found.compression])
    writer.start(profile="ros2", library=LIBRARY)
    for record in found.metadata:
        writer.add_metadata(record.name, record.metadata)
    channels = _declare(writer, found)
    kept = undeclared = 0
    for message in _messages(data, found):
        if message.channel not in channels:
            undeclared += 1
            continue
        writer.add_message(
            channels[message.channel], message.log_time, message.data, message.publish_time, message.sequence
        )
        kept += 1
    for attachment in found.attachments:
        writer.add_attachment(
            attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
        )
    writer.finish()
    file.close()
    return Copied(kept, undeclared, found.damaged, found.damages)


def _declare(writer: McapWriter, found: IntactRecords) -> dict[int, int]:
    """Declare all schemas and channels; returns the new id of each channel."""
    schemas = {k: writer.register_schema(s.name, s.encoding, s.data) for k, s in sorted(found.schemas.items())}
    return {
        k: writer.register_channel(c.topic, c.message_encoding, schemas.get(c.schema_id, 0), _as_stated(c.metadata))
        for k, c in sorted(found.channels.items())
        if not c.schema_id or c.schema_id in schemas
    }


def _as_stated(metadata: dict[str, str]) -> dict[str, str]:
    """A channel's metadata with its profiles as metadata.yaml will state them: rosbags reads no others."""
    if "offered_qos_profiles" not in metadata:
        return metadata
    return metadata | {"offered_qos_profiles": as_yaml(from_yaml(metadata["offered_qos_profiles"]))}


def _messages(data: memoryview, found: IntactRecords) -> Iterator[RawMessage]:
    """Every intact message in the order of the file."""
    places = sorted([(offset, True) for offset in found.chunks] + [(offset, False) for offset in found.loose])
    for offset, is_chunk in places:
        if is_chunk:
            chunk = chunk_at(data, offset)
            yield from (raw_message(chunk.data, k) for k in chunk.offsets)
        else:
            length = int.from_bytes(data[offset + 1 : offset + 9], "little")
            yield raw_message(bytes(data[offset : offset + 9 + length]))
