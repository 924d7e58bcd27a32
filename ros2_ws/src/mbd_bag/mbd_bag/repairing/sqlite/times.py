"""The second copy of each message's time: rosbag2 keeps an index of times, with the id of each row."""

from __future__ import annotations

from collections.abc import Sequence

from mbd_bag.repairing.sqlite.pages import Pages
from mbd_bag.repairing.sqlite.records import column_size, integer, is_integer, serial_types, varint
from mbd_bag.repairing.sqlite.rows import MessageRow

_INDEX_LEAF, _INDEX_INNER = 0x0A, 0x02


def indexed_times(pages: Pages) -> dict[int, int]:
    """The time of each row by the file's index of times [ns].

    Args:
        pages: of the file.
    """
    times: dict[int, int] = {}
    free = pages.free()
    for number in range(2, pages.count + 1):
        page = pages.page(number)
        if page is None or number in free or page[0] not in (_INDEX_LEAF, _INDEX_INNER):
            continue
        inner = page[0] == _INDEX_INNER
        count = int.from_bytes(page[3:5], "big")
        begin = 12 if inner else 8
        for k in range(min(count, (pages.usable - begin) // 2)):
            at = int.from_bytes(page[begin + 2 * k : begin + 2 * k + 2], "big")
            entry = _entry(page[: pages.usable], at + 4 if inner else at)
            if entry is not None:
                times[entry[1]] = entry[0]
    return times


def _entry(page: memoryview, at: int) -> tuple[int, int] | None:
    """Time and row of an entry of the index."""
    try:
        size, at = varint(page, at)
    except IndexError:
        return None
    record = page[at : at + size]
    parsed = serial_types(record, size) if size <= 32 else None
    if parsed is None or len(record) < size:
        return None
    types, begin = parsed
    if len(types) != 2 or not all(is_integer(t) for t in types):
        return None
    return integer(record, begin, types[0]), integer(record, begin + column_size(types[0]), types[1])


def rows_in_their_time(pages: Pages, rows: Sequence[MessageRow]) -> tuple[list[MessageRow], int]:
    """The rows whose time is not shown to be damaged, and how many others there are.

    A row whose time the index states otherwise is left out when that of the index lies between those of its neighbours
    and its own does not: then the index is the one that is intact.

    Args:
        pages: of the file.
        rows: of messages, by ascending id.
    """
    times = indexed_times(pages)
    kept: list[MessageRow] = []
    for k, row in enumerate(rows):
        stated = times.get(row.id, row.time)
        if stated == row.time or _fits(row.time, rows, k) or not _fits(stated, rows, k):
            kept.append(row)
    return kept, len(rows) - len(kept)


def _fits(time: int, rows: Sequence[MessageRow], k: int) -> bool:
    """Whether a time lies between those of the two rows before one and the two behind; True at either end."""
    before, after = rows[max(0, k - 2) : k], rows[k + 1 : k + 3]
    if not before or not after:
        return True
    around = [row.time for row in (*before, *after)]
    return min(around) <= time <= max(around)
