"""One file of a bag that rosbag2 stored as sqlite3 (its default up to Humble)."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from math import inf
from pathlib import Path

from mcap.records import Channel, Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import LARGEST_RECORD
from mbd_bag.formats.contents import BagMessage, FileContents
from mbd_bag.formats.known_definitions import known_definition

FIRST_BYTES = b"SQLite format 3\x00"
_STEP = 2_000  # instructions of sqlite between two looks at how many there were
# An intact file takes about one for each of its bytes: a row has 20 bytes or more, and is gone over a few times.
_STEPS_AT_LEAST, _STEPS_PER_BYTE = 20_000_000, 20
_SECONDS_AT_LEAST, _SECONDS_PER_BYTE = 10.0, 1e-6  # of processor time; an intact one takes a hundredth of that
_HINT = "`./mbd run mbd_bag repair` copies what is intact"


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
            with closing(self._open(self._patience)) as database:
                self.contents = _contents(database)
            self.contents.problem = "; ".join(filter(None, (self.contents.problem, self._unread())))
        except (sqlite3.Error, ValueError, OverflowError, TypeError) as error:
            raise BagError(f"{path} is no sqlite3 file of rosbag2, or damaged ({self._reason(error)})") from error

    def _open(self, seconds: float = inf) -> sqlite3.Connection:
        """Open the file; what takes more steps than its size allows, or more processor time than this, is ended."""
        name = self.path.absolute().as_posix().replace("%", "%25").replace("?", "%3f").replace("#", "%23")
        # Else sqlite makes files beside one whose last writer kept a write-ahead log, and refuses in a folder that
        # cannot be written.
        alone = "" if any(self._left_beside()) else "&immutable=1"
        database = sqlite3.connect(f"file:{name}?mode=ro{alone}", uri=True)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_RECORD)
        database.execute("PRAGMA trusted_schema = OFF")
        # Conditions on a table's rows may take any time, and say nothing of whether the file is intact.
        database.execute("PRAGMA ignore_check_constraints = ON")
        database.set_progress_handler(self._bound(seconds), _STEP)
        return database

    def _bound(self, seconds: float) -> Callable[[], bool]:
        begun = time.thread_time()
        left = (_STEPS_AT_LEAST + _STEPS_PER_BYTE * self.path.stat().st_size) // _STEP

        def is_beyond() -> bool:
            nonlocal left
            left -= 1
            return left < 0 or time.thread_time() - begun > seconds

        return is_beyond

    @property
    def _patience(self) -> float:
        return _SECONDS_AT_LEAST + _SECONDS_PER_BYTE * self.path.stat().st_size

    def _left_beside(self) -> list[Path]:
        """The journals that a writer left who did not close the file."""
        beside = (self.path.with_name(self.path.name + suffix) for suffix in ("-wal", "-journal"))
        return [p for p in beside if p.is_file() and _first(p, 8).strip(b"\0")]

    def _unread(self) -> str:
        """What sqlite does not read of a file whose writer died, since it was not committed; "" for nothing."""
        if left := self._left_beside():
            return f"its writer died and left {left[0].name}, in which there may be more; {_HINT}"
        header = _first(self.path, 100)
        size, pages, changed, valid_for = (
            int.from_bytes(header[k : k + n], "big") for k, n in ((16, 2), (28, 4), (24, 4), (92, 4))
        )
        size = 65536 if size == 1 else size
        behind = self.path.stat().st_size - pages * size
        if changed == valid_for and behind >= size:
            return f"its writer died: {behind} bytes at its end were not committed; {_HINT}"
        return ""

    def _reason(self, error: Exception) -> str:
        if str(error) == "interrupted":
            return "it asks for more than reading a file of its size takes: a view, a column or an index without end"
        if left := self._left_beside():
            return f"{error}; its writer died and left {left[0].name}; {_HINT}"
        return f"{error}; {_HINT}"

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
                for topic, logged, data in database.execute(query, [at for _, at in bounds]):
                    channel = channels[topic]
                    kind = self.contents.schemas[channel.schema_id].name
                    yield BagMessage(channel.topic, kind, int(logged), int(logged), bytes(data))
        except (sqlite3.Error, TypeError, ValueError) as error:
            raise BagError(f"{self.path} is damaged ({self._reason(error)})") from error

    def check(self) -> str:
        """As `BagFile.check`."""
        try:
            with closing(self._open(self._patience)) as database:
                (answer,) = database.execute("PRAGMA integrity_check(1)").fetchone()
        except sqlite3.Error as error:
            return f"{self.path} is damaged ({self._reason(error)})"
        return "" if answer == "ok" else f"{self.path} is damaged ({answer}; {_HINT})"


def _first(path: Path, number: int) -> bytes:
    """The first so many bytes of a file."""
    with path.open("rb") as stream:
        return stream.read(number)


def _contents(database: sqlite3.Connection) -> FileContents:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if missing := {"topics", "messages"} - tables:
        raise ValueError(f"it has no table {min(missing)}")
    for table in ("topics", "messages", "message_definitions"):
        # Computed for each row by what the file states; rosbag2 has none.
        if any(row[6] for row in database.execute(f"PRAGMA table_xinfo({table})")):
            raise ValueError(f"its table {table} has a column that is computed; expected those of rosbag2")
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
    counted = list(spans)
    rows_found = [row for row in counted if row[0] in found.channels]
    if lost := sum(int(row[1]) for row in counted if row[0] not in found.channels):
        found.problem = f"{lost} of its messages belong to no topic that it lists, and are not read"
    found.counts = {int(number): int(count) for number, count, _, _ in rows_found}
    if rows_found:
        found.start, found.end = min(int(r[2]) for r in rows_found), max(int(r[3]) for r in rows_found)
    if lacking:
        found.note = (
            f"it embeds no definition of {len(lacking)} types (recorded before Iron): those known here are taken"
        )
    return found
