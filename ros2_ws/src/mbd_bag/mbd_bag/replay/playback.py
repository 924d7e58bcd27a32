"""Which recorded messages are due: a session's own time, run at a rate, paused, stepped and started over."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mbd_model.times import to_nanoseconds

from mbd_bag.formats.contents import BagMessage

# Messages from this log time on [ns], in order.
Source = Callable[[int], Iterator[BagMessage]]


class Playback:
    """Runs through a bag by whatever clock it is asked with.

    Args:
        source: gives the messages.
        begin: log time of the part's first message to play [ns].
        end: log time of its last message to play [ns]; that is played too.
        rate: recorded seconds a second.
        loop: start over at the end.
        is_step: whether a step ends behind this message.

    Attributes:
        rate, loop, paused: may be changed at any time.
        position: log time reached [ns].
        rounds: how many times the end was reached.
    """

    def __init__(
        self,
        source: Source,
        begin: int,
        end: int,
        *,
        rate: float = 1.0,
        loop: bool = False,
        is_step: Callable[[BagMessage], bool] = lambda _: True,
    ) -> None:
        self._source = source
        self._begin, self._end = begin, end
        self._is_step = is_step
        self.rate, self.loop, self.paused = rate, loop, False
        self.rounds = 0
        self._asked: float | None = None
        self.jump(begin)

    @property
    def finished(self) -> bool:
        """True behind the last message, unless it loops."""
        return self._next is None

    def jump(self, log_time: int) -> None:
        """Go on from this log time [ns]."""
        self.position = log_time
        self._messages = self._source(log_time)
        self._next = self._following()

    def due(self, now: float, limit: int | None = None) -> list[BagMessage]:
        """The messages whose time has come since the last call.

        Args:
            now: of any clock that does not go back [s].
            limit: log time not to go beyond for now [ns], e.g. until somebody has answered.
        """
        passed = 0.0 if self._asked is None else now - self._asked
        self._asked = now
        if self.paused or self.finished:
            return []
        self.position += to_nanoseconds(passed * self.rate)
        if limit is not None:
            self.position = min(self.position, limit)
        found = []
        while self._next is not None and self._next.log_time <= self.position:
            found.append(self._take())
        if self._next is None:
            self._over()
        return found

    def step(self) -> list[BagMessage]:
        """The messages up to the end of the next step, at once; () at the end."""
        found: list[BagMessage] = []
        while self._next is not None:
            found.append(self._take())
            if self._is_step(found[-1]):
                break
        if found:
            self.position = found[-1].log_time
        if self._next is None:
            self._over()
        return found

    def _take(self) -> BagMessage:
        message = self._next
        if message is None:
            raise StopIteration("nothing is left to take")
        self._next = self._following()
        return message

    def _following(self) -> BagMessage | None:
        message = next(self._messages, None)
        return message if message is not None and message.log_time <= self._end else None

    def _over(self) -> None:
        self.rounds += 1
        if self.loop:
            self.jump(self._begin)
