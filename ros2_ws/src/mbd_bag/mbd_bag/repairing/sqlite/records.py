"""Cells and records of a leaf page of a table, by sqlite's description of its file format; nothing else is taken."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from itertools import pairwise

LEAF = 0x0D  # first byte of a table's leaf
TREE_KINDS = frozenset((0x02, 0x05, 0x0A, LEAF))  # of any page of a tree
_INTEGERS = (0, 1, 2, 3, 4, 6, 8)  # bytes by serial type


@dataclass(frozen=True, slots=True)
class LeafCell:
    """One row as it lies in its leaf page.

    Attributes:
        rowid: key of the row.
        size: of its record [byte].
        start: where the record begins in the page [byte].
        local: how much of it lies in the page [byte].
        onward: number of the first page that holds more of it; 0 for none.
    """

    rowid: int
    size: int
    start: int
    local: int
    onward: int


def varint(data: memoryview | bytes, at: int) -> tuple[int, int]:
    """An integer of 1 to 9 bytes, unsigned, and the place behind it; raises IndexError where the bytes end."""
    value = 0
    for k in range(8):
        byte = data[at + k]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, at + k + 1
    return value << 8 | data[at + 8], at + 9


def leaf_cells(page: memoryview, usable: int, header: int) -> tuple[list[LeafCell], bool]:
    """The rows of a table's leaf page.

    Args:
        page: its bytes.
        usable: of them [byte].
        header: where its header begins: 100 in the first page of a file, else 0.

    Returns:
        The well-formed cells in the order of their keys, and whether all of the page is consistent.
    """
    if page[header] != LEAF:
        return [], False
    count = int.from_bytes(page[header + 3 : header + 5], "big")
    pointers_end = header + 8 + 2 * count
    content = int.from_bytes(page[header + 5 : header + 7], "big") or 65536
    if pointers_end > usable:
        return [], False
    whole = pointers_end <= content <= usable and page[header + 7] <= 60
    found: list[tuple[int, int, LeafCell]] = []
    for k in range(count):
        at = int.from_bytes(page[header + 8 + 2 * k : header + 10 + 2 * k], "big")
        cell = _cell(page, at, usable) if pointers_end <= at <= usable - 4 else None
        if cell is None:
            whole = False
        else:
            found.append((at, max(cell.start + cell.local + (4 if cell.onward else 0), at + 4), cell))
    places = sorted((begin, end) for begin, end, _ in found)
    overlapping: set[int] = set()
    for (begin, end), (after, _) in pairwise(places):
        if after < end:
            overlapping |= {begin, after}
    if (places and places[0][0] < content) or overlapping:
        whole = False
    cells = [cell for begin, _, cell in found if begin not in overlapping]
    ordered = _ascending(cells)
    return ordered, whole and len(ordered) == count


def _cell(page: memoryview, at: int, usable: int) -> LeafCell | None:
    try:
        size, place = varint(page, at)
        rowid, place = varint(page, place)
    except IndexError:
        return None
    local = local_size(size, usable)
    end = place + local + (4 if local < size else 0)
    if not size or end > usable:
        return None
    onward = int.from_bytes(page[place + local : end], "big")
    if local < size and not onward:
        return None
    return LeafCell(rowid - (1 << 64) if rowid >> 63 else rowid, size, place, local, onward)


def local_size(size: int, usable: int) -> int:
    """How much of a record of a table lies in its leaf page [byte].

    Args:
        size: of the record [byte].
        usable: of a page [byte].
    """
    if size <= usable - 35:
        return size
    least = (usable - 12) * 32 // 255 - 23
    fitting = least + (size - least) % (usable - 4)
    return fitting if fitting <= usable - 35 else least


def _ascending(cells: list[LeafCell]) -> list[LeafCell]:
    """The most cells whose keys ascend, as those of an intact page do."""
    if all(a.rowid < b.rowid for a, b in pairwise(cells)):
        return cells
    tails: list[int] = []  # index of the last cell of the best run of each length
    before: list[int] = []
    keys: list[int] = []
    for k, cell in enumerate(cells):
        length = bisect_left(keys, cell.rowid)
        before.append(tails[length - 1] if length else -1)
        tails[length : length + 1] = [k]
        keys[length : length + 1] = [cell.rowid]
    kept: list[LeafCell] = []
    k = tails[-1]
    while k >= 0:
        kept.append(cells[k])
        k = before[k]
    return kept[::-1]


def serial_types(data: memoryview | bytes, size: int) -> tuple[tuple[int, ...], int] | None:
    """The types of a record's columns, and where its first column begins; None when they do not make up its size.

    Args:
        data: the record's beginning.
        size: of all of it [byte].
    """
    types: list[int] = []
    try:
        end, place = varint(data, 0)
        if end > len(data) or end > 100:
            return None
        while place < end:
            kind, place = varint(data, place)
            types.append(kind)
    except IndexError:
        return None
    if place != end or end + sum(column_size(kind) for kind in types) != size:
        return None
    return tuple(types), end


def column_size(kind: int) -> int:
    """How many bytes a column of this serial type has."""
    if kind >= 12:
        return (kind - 12) // 2
    return _INTEGERS[kind] if kind < 7 else (8 if kind == 7 else 0)


def is_integer(kind: int) -> bool:
    """Whether a serial type is that of an integer."""
    return 1 <= kind <= 6 or kind in (8, 9)


def is_text(kind: int) -> bool:
    """Whether a serial type is that of a text."""
    return kind >= 13 and kind % 2 == 1


def is_blob(kind: int) -> bool:
    """Whether a serial type is that of bytes."""
    return kind >= 12 and kind % 2 == 0


def integer(data: memoryview | bytes, at: int, kind: int) -> int:
    """An integer column at a place of a record."""
    if kind in (8, 9):
        return kind - 8
    return int.from_bytes(data[at : at + _INTEGERS[kind]], "big", signed=True)
