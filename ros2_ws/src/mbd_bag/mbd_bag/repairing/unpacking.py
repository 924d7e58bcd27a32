"""Unpack a file that rosbag2 compressed in one piece as far as that goes."""

from __future__ import annotations

from pathlib import Path

import zstandard

from mbd_bag.formats.packed import SUFFIX
from mbd_bag.formats.summary import refuse_bomb

_PIECE = 1 << 12  # [byte] given at once: what was unpacked before a fault is kept


def unpack_intact(path: Path, folder: Path) -> tuple[Path, str]:
    """Unpack a file into a folder up to what cannot be unpacked.

    Without a checksum, which rosbag2 does not ask for, bytes before the fault may be other ones than were packed.

    Args:
        path: compressed by zstd.
        folder: to write into.

    Returns:
        The unpacked file, and what is wrong with the compressed one; "" for nothing.
    """
    out = folder / path.name.removesuffix(SUFFIX)
    size, written = path.stat().st_size, 0
    problem = ""
    with path.open("rb") as packed, out.open("wb") as stream:
        unpacking = zstandard.ZstdDecompressor().decompressobj()
        try:
            while not unpacking.eof and (piece := packed.read(_PIECE)):
                data = unpacking.decompress(piece)
                written += len(data)
                refuse_bomb(written, size)
                stream.write(data)
            if not unpacking.eof:
                raise ValueError("it is cut off")
        except (zstandard.ZstdError, ValueError) as error:
            problem = f"{path.name}: cannot be unpacked behind its first {written} bytes ({error})"
    return out, problem
