"""The rows of rosbag2's tables in the leaf pages of a file, told by their columns: no other page is needed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from mbd_bag.repairing.sqlite.pages import Pages
from mbd_bag.repairing.sqlite.records import (
    LEAF,
    LeafCell,
    column_size,
    integer,
    is_blob,
    is_integer,
    is_text,
    serial_types,
)

_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_/]*")
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)+")
_LONGEST_TEXT = 1 << 22  # [byte] of a row of texts
_NULL = 0


@dataclass(frozen=True, slots=True)
class MessageRow:
    """A row of the table of messages.

    Attributes:
        id: of the row; it ascends in the order of recording.
        topic: id of its topic.
        time: when it was recorded [ns].
        page: number of its leaf page.
        leaf: bytes of that page.
        cell: where it lies there.
        offset: where its data begins in the record [byte].
    """

    id: int
    topic: int
    time: int
    page: int
    leaf: memoryview
    cell: LeafCell
    offset: int


@dataclass(frozen=True, slots=True)
class TopicRow:
    """A row of the table of topics: its columns, and the name and type that it states."""

    id: int
    name: str
    msgtype: str
    form: str
    qos: str
    type_hash: str


@dataclass
class BagRows:
    """The rows found in a file.

    Attributes:
        messages: in no order; of one id there may be several.
        topics: by id.
        definitions: encoding and text by type.
        metadata: what rosbag2 keeps of metadata.yaml in the file, "" for nothing.
        text_pages: numbers of the pages that rows of the other tables go on in.
        damaged_pages: numbers of leaf pages that are not consistent.
        ill_formed: rows of consistent leaf pages, or parts of damaged ones, that are no row of any table.
    """

    messages: list[MessageRow] = field(default_factory=list)
    topics: dict[int, TopicRow] = field(default_factory=dict)
    definitions: dict[str, tuple[str, str]] = field(default_factory=dict)
    metadata: str = ""
    text_pages: set[int] = field(default_factory=set)
    damaged_pages: set[int] = field(default_factory=set)
    ill_formed: int = 0


def find_rows(pages: Pages) -> BagRows:
    """Look at every page of a file for rows of rosbag2's tables.

    Args:
        pages: of the file.
    """
    found = BagRows()
    free = pages.free()
    for number in range(1, pages.count + 1):
        page = pages.page(number)
        if page is None or number in free or page[100 if number == 1 else 0] != LEAF:
            continue
        cells, whole, page = pages.cells(number)
        if not whole:
            found.damaged_pages.add(number)
        for cell in cells:
            _take(found, pages, number, page, cell)
    return found


@dataclass(frozen=True)
class _Record:
    """A row whose columns make up its size: its page, where it lies there, their types, where the first begins."""

    number: int
    page: memoryview
    cell: LeafCell
    types: tuple[int, ...]
    begin: int


def _take(found: BagRows, pages: Pages, number: int, page: memoryview, cell: LeafCell) -> None:
    data = page[cell.start : cell.start + cell.local]
    parsed = serial_types(data, cell.size)
    if parsed is None:
        found.ill_formed += 1
        return
    types, begin = parsed
    record = _Record(number, page, cell, types, begin)
    # The id lies in the row's key where the column is declared as that, else in the column.
    own = not types or types[0] == _NULL or is_integer(types[0])
    if len(types) == 4 and own and is_integer(types[1]) and is_integer(types[2]) and is_blob(types[3]):
        row = _message_row(record, data)
        if row.time >= 0:
            found.messages.append(row)
        else:
            found.ill_formed += 1
    elif len(types) in (5, 6) and own and all(is_text(t) or t == _NULL for t in types[1:]):
        _take_texts(found, pages, record)
    elif len(types) == 3 and own and is_integer(types[1]) and is_text(types[2]):
        texts = _texts(found, pages, record)
        # rosbag2 adds a row when it closes the file; the first one counts no message.
        found.metadata = texts[2] if texts is not None else found.metadata


def _message_row(record: _Record, data: memoryview) -> MessageRow:
    types = record.types
    topic_at = record.begin + column_size(types[0])
    time_at = topic_at + column_size(types[1])
    topic, time = integer(data, topic_at, types[1]), integer(data, time_at, types[2])
    offset = time_at + column_size(types[2])
    return MessageRow(record.cell.rowid, topic, time, record.number, record.page, record.cell, offset)


def _take_texts(found: BagRows, pages: Pages, record: _Record) -> None:
    """Take a row of the topics, or of the definitions of types: an encoding, such as ros2msg, is no name of a type."""
    texts, types = _texts(found, pages, record), record.types
    if texts is None:
        return
    if _TOPIC.fullmatch(texts[1]) and _TYPE.fullmatch(texts[2]):
        data = record.page[record.cell.start :]
        number = integer(data, record.begin, types[0]) if types[0] != _NULL else record.cell.rowid
        _, name, msgtype, form, qos, *type_hash = texts
        found.topics[number] = TopicRow(number, name, msgtype, form, qos, "".join(type_hash))
    elif len(types) == 5 and _TYPE.fullmatch(texts[1]):
        found.definitions[texts[1]] = (texts[2], texts[3])


def _texts(found: BagRows, pages: Pages, record: _Record) -> list[str] | None:
    """The columns of a row as texts, "" for those that are none; None when they cannot be read."""
    if record.cell.size > _LONGEST_TEXT:
        return None
    data = record_bytes(pages, record.page, record.cell)
    if data is None:
        return None
    follow(pages, record.cell, lambda number, _: found.text_pages.add(number))
    texts: list[str] = []
    at = record.begin
    try:
        for kind in record.types:
            end = at + column_size(kind)
            texts.append(data[at:end].decode() if is_text(kind) else "")
            at = end
    except UnicodeDecodeError:
        return None
    return texts


def record_bytes(pages: Pages, page: memoryview, cell: LeafCell) -> bytes | None:
    """All of a record, with what lies in further pages; None when those do not make it up.

    Args:
        pages: of the file.
        page: the leaf.
        cell: where it lies there.
    """
    parts = [bytes(page[cell.start : cell.start + cell.local])]
    left = cell.size - cell.local

    def add(number: int, further: memoryview) -> None:
        nonlocal left
        part = bytes(further[4 : 4 + min(left, pages.usable - 4)])
        left -= len(part)
        parts.append(part)

    return b"".join(parts) if follow(pages, cell, add) else None


def follow(pages: Pages, cell: LeafCell, each: Callable[[int, memoryview], object]) -> bool:
    """Go through the further pages of a record; whether they are as many as it needs, and then end.

    Args:
        pages: of the file.
        cell: where it begins.
        each: is given number and bytes of every one.
    """
    number = cell.onward
    needed = -(-(cell.size - cell.local) // (pages.usable - 4))
    if needed > pages.count:
        return False
    for _ in range(needed):
        page = pages.page(number)
        if page is None:
            return False
        each(number, page)
        number = int.from_bytes(page[:4], "big")
    return number == 0
