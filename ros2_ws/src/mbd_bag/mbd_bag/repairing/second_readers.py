"""Whether other readers take a bag, and read as many messages of it as we do."""

from __future__ import annotations

from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader, ReaderError

from mbd_bag.errors import BagError


def refuse_unreadable(folder: Path, expected: int) -> None:
    """Read a bag that was just written with rosbags and with mcap.

    Args:
        folder: the bag.
        expected: how many messages it should hold.

    Raises:
        BagError: one of them does not take it, or reads another number of messages.
    """
    try:
        with Reader(folder) as reader:
            stated, by_rosbags = reader.message_count, sum(1 for _ in reader.messages())
        by_mcap = 0
        for path in sorted(folder.glob("*.mcap")):
            with path.open("rb") as stream:
                by_mcap += sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
    except (ReaderError, McapError, OSError, ValueError, KeyError, AssertionError) as error:
        raise BagError(f"the copy {folder} was written, but another reader does not take it: {error}") from error
    if not stated == by_rosbags == by_mcap == expected:
        raise BagError(
            f"the copy {folder} was written, but of its {expected} messages rosbags reads {by_rosbags} of {stated} "
            f"and mcap {by_mcap}"
        )
