"""Files and messages that rosbag2 compressed with zstd in one piece, unpacked within bounds."""

from __future__ import annotations

import shutil
from collections.abc import Collection, Iterator
from pathlib import Path

import zstandard

from mbd_bag.errors import BagError
from mbd_bag.formats.bag_file import BagFile
from mbd_bag.formats.chunks import LARGEST_RECORD
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.summary import refuse_bomb

SUFFIX = ".zstd"
_PIECE = 1 << 20
_SPARE = 200_000_000  # [byte] left free on the disk


def unpack(path: Path, folder: Path) -> Path:
    """Unpack a file into a folder; returns the unpacked file.

    Raises:
        BagError: it is missing, damaged, larger than a recorded one, or the disk has no room for it.
    """
    out = folder / path.name.removesuffix(SUFFIX)
    if not path.is_file():
        raise BagError(f"{path} is missing; the bag's metadata.yaml names it. Put it back beside the others")
    size, written = path.stat().st_size, 0
    try:
        with path.open("rb") as packed, out.open("wb") as stream:
            for piece in zstandard.ZstdDecompressor().read_to_iter(packed, write_size=_PIECE):
                written += len(piece)
                refuse_bomb(written, size)
                if shutil.disk_usage(folder).free < _SPARE:
                    raise ValueError("the disk has no room to unpack it; make room, or set TMPDIR")
                stream.write(piece)
    except (zstandard.ZstdError, ValueError, OSError) as error:
        raise BagError(f"{path} cannot be unpacked: {error}") from error
    if not written:
        raise BagError(f"{path} holds nothing that can be unpacked: it is empty or cut off")
    return out


class PackedMessages:
    """A file each of whose messages is compressed.

    Args:
        file: whose messages they are.
    """

    def __init__(self, file: BagFile) -> None:
        self._file = file
        self.path, self.contents = file.path, file.contents

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """As `BagFile.messages`; raises BagError for one that cannot be unpacked."""
        for message in self._file.messages(topics, start, end):
            data = self._unpacked(message)
            yield BagMessage(message.topic, message.msgtype, message.log_time, message.publish_time, data)

    def _unpacked(self, message: BagMessage) -> bytes:
        try:
            if zstandard.frame_content_size(message.data) > LARGEST_RECORD:
                raise ValueError(f"it would take more than {LARGEST_RECORD} bytes")
            return zstandard.ZstdDecompressor().decompress(message.data, max_output_size=LARGEST_RECORD)
        except (zstandard.ZstdError, ValueError) as error:
            raise BagError(f"{self.path}: a message on {message.topic} cannot be unpacked: {error}") from error

    def check(self) -> str:
        """As `BagFile.check`."""
        try:
            for _ in self.messages():
                pass
        except BagError as error:
            return str(error)
        return self._file.check()
