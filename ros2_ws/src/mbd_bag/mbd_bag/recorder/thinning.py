"""Which images of a stream are kept when fewer a second will do."""

from __future__ import annotations

import struct


def header_stamp(message: bytes) -> int:
    """Stamp of a serialized message that starts with a Header [ns], without decoding the rest of it."""
    seconds, nanoseconds = struct.unpack_from("<iI" if message[1] & 1 else ">iI", message, 4)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


class Thinning:
    """Keeps the first message of each period of time.

    Periods are counted from time 0 by the message's own stamp, so colour, depth and camera_info of one moment are kept
    or left out together.

    Args:
        rate: at most so many a second [Hz]; 0: all.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._period = -1

    def keeps(self, message: bytes) -> bool:
        """Whether to keep this message (CDR bytes, a Header first)."""
        if not self._rate:
            return True
        period = int(header_stamp(message) * self._rate / 1e9)
        kept = period != self._period
        self._period = period
        return kept
