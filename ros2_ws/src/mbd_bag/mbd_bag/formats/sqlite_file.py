"""One file of a bag that rosbag2 stored as sqlite3 (its default up to Humble)."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing
from pathlib import Path

from mcap.records import Channel, Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import LARGEST_RECORD
from mbd_bag.formats.contents import BagMessage, FileContents
from mbd_bag.formats.known_definitions import known_definition

FIRST_BYTES = b"SQLite format 3\x00"


class SqliteFile:
    """A .db3 file.

    Args:
        path: of the file.

    Attributes:
        path: what was opened.
        contents: what it holds; of a type that the file does not define, the definition that is known here.

    Raises:
        BagError: it is missing, or no bag of rosbag2.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise BagError(f"{path} is missing; the bag's metadata.yaml names it. Put it back beside the others")
        try:
            with closing(self._open()) as database:
                self.contents = _contents(database)
        except (sqlite3.Error, ValueError, OverflowError, TypeError) as error:
            raise BagError(f"{path} is no sqlite3 file of rosbag2, or damaged ({error})") from error

    def _open(self) -> sqlite3.Connection:
        database = sqlite3.connect(f"file:{self.path.absolute().as_posix().replace('?', '%3f')}?mode=ro", uri=True)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_RECORD)
        database.execute("PRAGMA trusted_schema = OFF")
        return database

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """As `BagFile.messages`; raises BagError when the file is damaged."""
        channels = self.contents.channels
        wanted = [k for k, c in channels.items() if topics is None or c.topic in topics]
        if not wanted:
            return
        # Numbers of ours only, no text of the file.
        query = f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({','.join(map(str, wanted))})"
        bounds = [(f" AND timestamp {sign} ?", at) for sign, at in ((">=", start), ("<", end)) if at is not None]
        query += "".join(text for text, _ in bounds) + " ORDER BY timestamp, id"
        try:
            with closing(self._open()) as database:
                for topic, time, data in database.execute(query, [at for _, at in bounds]):
                    channel = channels[topic]
                    kind = self.contents.schemas[channel.schema_id].name
                    yield BagMessage(channel.topic, kind, int(time), int(time), bytes(data))
        except (sqlite3.Error, TypeError, ValueError) as error:
            raise BagError(f"{self.path} is damaged ({error}); `sqlite3 FILE .recover` saves what it can") from error

    def check(self) -> str:
        """As `BagFile.check`."""
        try:
            with closing(self._open()) as database:
                (answer,) = database.execute("PRAGMA integrity_check(1)").fetchone()
        except sqlite3.Error as error:
            answer = str(error)
        return "" if answer == "ok" else f"{self.path} is damaged ({answer}); `sqlite3 FILE .recover` saves what it can"


def _contents(database: sqlite3.Connection) -> FileContents:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if missing := {"topics", "messages"} - tables:
        raise ValueError(f"it has no table {min(missing)}")
    defined: dict[str, tuple[str, str]] = {}
    if "message_definitions" in tables:
        rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
        defined = {str(kind): (str(encoding), str(text)) for kind, encoding, text in rows}
    found = FileContents()
    numbers: dict[str, int] = {}
    lacking: list[str] = []
    columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
    qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
    for number, topic, kind, form, offered in database.execute(
        f"SELECT id, name, type, serialization_format, {qos} FROM topics"
    ):
        if not isinstance(kind, str) or not isinstance(topic, str):
            raise ValueError(f"topic {number} has a name or type that is no text")
        if kind not in numbers:
            numbers[kind] = len(numbers) + 1
            encoding, text = defined.get(kind, ("", ""))
            if not text:
                lacking.append(kind)
                encoding, text = known_definition(kind)
            found.schemas[numbers[kind]] = Schema(numbers[kind], text.encode(), encoding, kind)
        found.channels[int(number)] = Channel(
            int(number), topic, str(form), {"offered_qos_profiles": str(offered)}, numbers[kind]
        )
    spans = database.execute(
        "SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp) FROM messages GROUP BY topic_id"
    )
    rows_found = [row for row in spans if row[0] in found.channels]
    found.counts = {int(number): int(count) for number, count, _, _ in rows_found}
    if rows_found:
        found.start, found.end = min(int(r[2]) for r in rows_found), max(int(r[3]) for r in rows_found)
    if lacking:
        found.note = (
            f"it embeds no definition of {len(lacking)} types (recorded before Iron): those known here are taken"
        )
    return found
