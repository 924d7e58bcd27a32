"""The pages of a sqlite3 file, also of one whose header is damaged or whose end is missing."""

from __future__ import annotations

import mmap
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mbd_bag.repairing.sqlite.journals import journal_pages, log_page_size, log_pages
from mbd_bag.repairing.sqlite.records import LEAF, LeafCell, leaf_cells

_SIZES = (4096, 512, 1024, 2048, 8192, 16384, 32768, 65536)  # rosbag2's first
_SAMPLE = 200  # leaf pages looked at for each size


@dataclass(frozen=True)
class Pages:
    """The pages of a file, numbered from 1.

    Attributes:
        data: of the file.
        size: of a page [byte].
        usable: of each page [byte].
        newer: pages of a write-ahead log, which stand for those of the file.
        older: pages of a rollback journal, for those of the file that are damaged.
    """

    data: memoryview
    size: int
    usable: int
    newer: Mapping[int, bytes] = field(default_factory=dict)
    older: Mapping[int, bytes] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of the last page that is there in full."""
        return max(len(self.data) // self.size, max(self.newer, default=0))

    def page(self, number: int) -> memoryview | None:
        """A page's bytes; None where the file has no such page in full."""
        if number in self.newer:
            return memoryview(self.newer[number])
        begin = (number - 1) * self.size
        if number < 1 or begin + self.size > len(self.data):
            return None
        return self.data[begin : begin + self.size]

    def cells(self, number: int) -> tuple[list[LeafCell], bool, memoryview]:
        """The rows of a leaf page, whether it is consistent, and its bytes; ([], False, ...) for any other page."""
        page = self.page(number)
        if page is None:
            return [], False, memoryview(b"")
        header = 100 if number == 1 else 0
        cells, whole = leaf_cells(page, self.usable, header)
        if not whole and number in self.older:
            before = memoryview(self.older[number])
            old_cells, old_whole = leaf_cells(before, self.usable, header)
            if old_whole:
                return old_cells, True, before
        return cells, whole, page

    def free(self) -> frozenset[int]:
        """The pages that hold nothing any more, by the file's list of them; none when that is damaged."""
        first = self.page(1)
        if first is None:
            return frozenset()
        trunk, stated = (int.from_bytes(first[k : k + 4], "big") for k in (32, 36))
        found: set[int] = set()
        while trunk and len(found) < stated:
            page = self.page(trunk)
            if page is None or trunk in found:
                return frozenset()
            count = int.from_bytes(page[4:8], "big")
            if 8 + 4 * count > self.usable:
                return frozenset()
            found.add(trunk)
            found |= {int.from_bytes(page[8 + 4 * k : 12 + 4 * k], "big") for k in range(count)}
            trunk = int.from_bytes(page[:4], "big")
        return frozenset(found) if len(found) == stated and not trunk else frozenset()

    def maps(self) -> frozenset[int]:
        """The pages that belong to no table: the one at 1 GB, and those that sqlite's auto-vacuum keeps."""
        first = self.page(1)
        apart = {(1 << 30) // self.size + 1}
        if first is not None and any(first[52:56]):
            apart |= set(range(2, self.count + 1, self.usable // 5 + 1))
        return frozenset(apart)


def open_pages(path: Path) -> Pages:
    """The pages of a file, with those of a write-ahead log or a rollback journal beside it; all are only read."""
    with path.open("rb") as stream:
        empty = not path.stat().st_size
        data = memoryview(b"" if empty else mmap.mmap(stream.fileno(), 0, prot=mmap.PROT_READ))
    log, journal = (_beside(path, suffix) for suffix in ("-wal", "-journal"))
    size, reserved = page_size(data)
    if size == 0:
        size, reserved = log_page_size(log) if log_page_size(log) in _SIZES else _SIZES[0], 0
    return Pages(data, size, size - reserved, log_pages(log, size), journal_pages(journal, size))


def _beside(path: Path, suffix: str) -> bytes:
    other = path.with_name(path.name + suffix)
    return other.read_bytes() if other.is_file() else b""


def page_size(data: memoryview) -> tuple[int, int]:
    """Size of a page, and how many bytes at its end are not used [byte]; (0, 0) when no page shows it.

    The header's own statement may be damaged: that size is taken whose leaf pages hold most rows.

    Args:
        data: of the file.
    """
    stated = int.from_bytes(data[16:18], "big") if len(data) > 20 else 0
    stated = 65536 if stated == 1 else stated
    unused = data[20] if len(data) > 20 else 0
    best = (0, 0, 0)
    for size in sorted(_SIZES, key=lambda s: s != stated):
        for reserved in dict.fromkeys((0, unused)):
            if size - reserved < 480 or (best[0] and reserved):
                continue
            rows = _rows(data, size, size - reserved)
            if rows > best[0]:
                best = (rows, size, reserved)
    return best[1:]


def _rows(data: memoryview, size: int, usable: int) -> int:
    """Rows in consistent leaf pages, were pages of this size."""
    whole = len(data) // size
    firsts = np.frombuffer(data[: whole * size], dtype=np.uint8)[::size] if whole else np.zeros(0, dtype=np.uint8)
    rows = 0
    for number in np.flatnonzero(firsts == LEAF)[:_SAMPLE]:
        begin = int(number) * size
        cells, consistent = leaf_cells(data[begin : begin + size], usable, 0)
        # sqlite fills a page from its end: one of a smaller size would end before.
        end = max((cell.start + cell.local + (4 if cell.onward else 0) for cell in cells), default=0)
        rows += len(cells) if consistent and end == usable else 0
    return rows
