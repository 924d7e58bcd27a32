"""Pages that sqlite left beside a file when its writer died: in a write-ahead log, or in a rollback journal.

Both by sqlite's description of its file format. A frame of the log carries a checksum over itself and all before it, so
that each intact one can be told, also behind damage, by the checksum that the frame before it states. A record of a
rollback journal carries a weaker one, over every 200th byte.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

_LOG_HEADER, _FRAME_HEADER = 32, 24
_LOG_MAGICS = {0x377F0682: "<u4", 0x377F0683: ">u4"}  # how the checksum reads its words
_JOURNAL_MAGIC = bytes.fromhex("d9d505f920a163d7")


@lru_cache(maxsize=8)
def _fibonacci(number: int) -> npt.NDArray[np.uint32]:
    """F(0) ... F(number), modulo 2**32."""
    values = [0, 1]
    while len(values) <= number:
        values.append((values[-1] + values[-2]) & 0xFFFFFFFF)
    return np.array(values, dtype=np.uint32)


def log_checksum(data: bytes, words: str, start: tuple[int, int]) -> tuple[int, int]:
    """The checksum of a write-ahead log, continued over some bytes.

    It is s1 += x[k] + s2; s2 += x[k + 1] + s1: s1, s2, s1, ... are a Fibonacci series with a term added to each.

    Args:
        data: a multiple of 8 bytes.
        words: dtype of its 32-bit words.
        start: both sums before.
    """
    x = np.frombuffer(data, dtype=words).astype(np.uint32)
    f = _fibonacci(len(x) + 1)
    n = len(x)
    before = np.array(start, dtype=np.uint32)
    # F(n - 1 - k) of each word in the sum before the last, F(n - k) in the last.
    first = int(np.sum(f[n - 1 :: -1][:n] * x, dtype=np.uint32)) + int(f[n - 1]) * int(before[0])
    second = int(np.sum(f[n:0:-1] * x, dtype=np.uint32)) + int(f[n]) * int(before[0])
    return (first + int(f[n]) * int(before[1])) & 0xFFFFFFFF, (second + int(f[n + 1]) * int(before[1])) & 0xFFFFFFFF


def _pair(data: bytes) -> tuple[int, int]:
    return int.from_bytes(data[:4], "big"), int.from_bytes(data[4:8], "big")


def log_page_size(data: bytes) -> int:
    """The page size that a write-ahead log states [byte]; 0 when it is none."""
    known = len(data) >= _LOG_HEADER and int.from_bytes(data[:4], "big") in _LOG_MAGICS
    return int.from_bytes(data[8:12], "big") if known else 0


def log_pages(data: bytes, size: int) -> dict[int, bytes]:
    """The newest intact image of each page in a write-ahead log.

    Args:
        data: of the ``-wal`` file.
        size: of a page [byte].

    Returns:
        Pages by number, from 1. Those that were not yet committed are among them: they were written whole.
    """
    words = _LOG_MAGICS.get(int.from_bytes(data[:4], "big"))
    step = _FRAME_HEADER + size
    found: dict[int, bytes] = {}
    if len(data) < _LOG_HEADER + step or words is None:
        return found
    header_is_intact = log_checksum(data[:24], words, (0, 0)) == _pair(data[24:32])
    salts = data[16:24] if header_is_intact else data[_LOG_HEADER + 8 : _LOG_HEADER + 16]
    before = _pair(data[24:32])
    for place in range(_LOG_HEADER, len(data) - step + 1, step):
        header, page = data[place : place + _FRAME_HEADER], data[place + _FRAME_HEADER : place + step]
        stated = _pair(header[16:24])
        if header[8:16] == salts and log_checksum(header[:8] + page, words, before) == stated:
            found[int.from_bytes(header[:4], "big")] = page
        before = stated
    return found


def journal_pages(data: bytes, size: int) -> dict[int, bytes]:
    """The intact images of pages in a rollback journal, as they were before the last transaction.

    Args:
        data: of the ``-journal`` file.
        size: of a page [byte].

    Returns:
        Pages by number, from 1; {} for a journal that is done with.
    """
    found: dict[int, bytes] = {}
    place = 0
    while data[place : place + 8] == _JOURNAL_MAGIC:
        numbers = [int.from_bytes(data[place + k : place + k + 4], "big") for k in range(8, 28, 4)]
        count, nonce, _, sector, stated = numbers
        if stated != size or not 32 <= sector <= 65536:
            break
        place += sector
        room = (len(data) - place) // (size + 8)
        for _ in range(room if count == 0xFFFFFFFF else min(count, room)):
            page = data[place + 4 : place + 4 + size]
            checksum = int.from_bytes(data[place + 4 + size : place + 8 + size], "big")
            if (nonce + sum(page[k] for k in range(size - 200, 0, -200))) & 0xFFFFFFFF == checksum:
                # The first image of a page is the oldest.
                found.setdefault(int.from_bytes(data[place : place + 4], "big"), page)
            place += size + 8
        place += -place % sector
    return found
