"""Write what is intact in a sqlite3 file of rosbag2 into a new MCAP file, which has checksums."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from mbd_bag.repairing.sqlite.chains import rows_with_their_pages
from mbd_bag.repairing.sqlite.definitions import Messages, are_packed, is_message
from mbd_bag.repairing.sqlite.pages import open_pages
from mbd_bag.repairing.sqlite.rows import BagRows, MessageRow, TopicRow, find_rows
from mbd_bag.repairing.sqlite.times import rows_in_their_time
from mbd_bag.repairing.sqlite.topics import topics_of
from mbd_bag.repairing.stated_topics import StatedTopic
from mbd_bag.storage.mcap_file import LIBRARY
from mbd_bag.storage.record_file import RecordFile
from mbd_bag.storage.topic_qos import as_yaml, from_yaml


@dataclass(frozen=True)
class SavedRows:
    """What became of one sqlite3 file.

    Attributes:
        kept: messages in the copy.
        pages: with rows that are not consistent.
        lost: ids up to the last one found that no row has that was kept.
        broken: messages whose further pages are missing, or another's.
        untimed: messages whose time is another one in the file's index and does not fit its neighbours.
        undeclared: messages whose topic is not known.
        unlike: messages that are none of their topic's type.
        stated: messages that the bag had by metadata.yaml; 0 when it does not say.
    """

    kept: int
    pages: int
    lost: int
    broken: int
    untimed: int
    undeclared: int
    unlike: int
    stated: int

    def sentences(self, name: str) -> tuple[str, ...]:
        """What was kept and lost of a file of this name, for people, one for each kind."""
        kinds = (
            (self.pages, "pages with rows are damaged; of these what is well-formed is taken"),
            (self.broken, "messages are lost since pages that they go on in are missing or damaged"),
            (self.untimed, "messages are left out since their time is damaged"),
            (self.undeclared, "messages are left out since their topic is not known"),
            (self.unlike, "messages are left out since they are none of their topic's type"),
        )
        lost = f"{self.lost} more are lost, by the ids of their rows" if self.lost else "no row is missing"
        if self.stated - self.kept > self.lost:  # the end is missing, and with it the last ids
            lost = f"{self.stated - self.kept} more are lost, by metadata.yaml"
        return (
            f"{name}: {self.kept} messages kept; {lost}",
            *(f"{name}: {count} {text}" for count, text in kinds if count),
        )


def copy_rows(source: Path, out: Path, stated: Sequence[StatedTopic] = ()) -> SavedRows:
    """Copy all that is intact in a sqlite3 file; the file itself is only read.

    Args:
        source: the damaged file.
        out: the MCAP file to write; it must not exist.
        stated: the topics of its bag by metadata.yaml.

    Raises:
        OSError: it exists, or the disk is full.
    """
    pages = open_pages(source)
    found = find_rows(pages)
    rows = _one_of_each(found)
    last = rows[-1].id if rows else 0
    rows, broken = rows_with_their_pages(pages, rows, found.text_pages)
    rows, untimed = rows_in_their_time(pages, rows)
    messages = Messages(pages, are_packed(pages, rows))
    by_topic: dict[int, list[MessageRow]] = {}
    for row in rows:
        by_topic.setdefault(row.topic, []).append(row)
    topics, definitions = topics_of(found, messages, by_topic, stated)

    file = RecordFile(out)
    writer = McapWriter(cast(IO[bytes], file), compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library=LIBRARY)
    schemas = {k: writer.register_schema(k, d.encoding, d.text.encode()) for k, d in sorted(definitions.items())}
    channels = {
        k: writer.register_channel(t.name, t.form, schemas[t.msgtype], _metadata(t)) for k, t in sorted(topics.items())
    }
    decoders = {kind: d.decoder for kind, d in definitions.items() if d.fits}
    kept = undeclared = unlike = 0
    for row in rows:
        if row.topic not in channels:
            undeclared += 1
            continue
        topic, data = topics[row.topic], messages.data(row)
        decoder = decoders.get(topic.msgtype)
        if data is None or (decoder is not None and not is_message(decoder, topic.msgtype, data)):
            unlike += 1
            continue
        if topic.form == "cdr" and not _is_cdr(data):
            unlike += 1
            continue
        writer.add_message(channels[row.topic], row.time, data, row.time)
        kept += 1
    writer.finish()
    file.close()
    # rosbag2 numbers the rows of each file from 1.
    lost = last - kept if last <= 2 * len(found.messages) + 1000 else 0
    return SavedRows(
        kept, len(found.damaged_pages), lost, broken, untimed, undeclared, unlike, sum(t.count for t in stated)
    )


def _metadata(topic: TopicRow) -> dict[str, str]:
    """What a channel states of its topic, as metadata.yaml will."""
    stated = {"offered_qos_profiles": as_yaml(from_yaml(topic.qos))}
    return stated | ({"topic_type_hash": topic.type_hash} if topic.type_hash else {})


def _one_of_each(found: BagRows) -> list[MessageRow]:
    """The rows of messages by id; of several with one id, that of an intact page."""
    best: dict[int, MessageRow] = {}
    for row in found.messages:
        other = best.get(row.id)
        if other is None or (other.page in found.damaged_pages and row.page not in found.damaged_pages):
            best[row.id] = row
    return [best[k] for k in sorted(best)]


def _is_cdr(data: bytes) -> bool:
    """Whether bytes begin as CDR does: with the number of an encoding."""
    return len(data) >= 4 and data[0] == 0 and data[1] <= 0x0D
