"""What came before the simulated clock: held until that tells the time, for none of it is of the year 1970."""

from __future__ import annotations

from collections.abc import Callable

_MOST = 64 << 20  # [byte] of pictures


class HeldMessages:
    """Writes that wait for the clock, in the order they came."""

    def __init__(self) -> None:
        self._writes: list[Callable[[], object]] = []
        self._bytes = 0

    def __bool__(self) -> bool:
        """True while any waits."""
        return bool(self._writes)

    def hold(self, write: Callable[[], object], size: int, *, picture: bool) -> bool:
        """Have a message wait; False for a picture for which there is no room.

        Args:
            write: writes it.
            size: of it [byte].
            picture: whether it may be left out.
        """
        if picture and self._bytes + size > _MOST:
            return False
        self._bytes += size
        self._writes.append(write)
        return True

    def release(self) -> None:
        """Write what waits."""
        writes, self._writes, self._bytes = self._writes, [], 0
        for write in writes:
            write()
