"""What became of a topic's messages on their way into the bag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

# A larger step of the sequence number is another publisher, not a loss.
_LARGEST_GAP = 100_000
FACT = "counts."  # begins the names of a bag's facts on this


@dataclass
class TopicCount:
    """Of one topic.

    Attributes:
        received: messages that arrived.
        written: of them in the bag.
        lost: that were published and did not arrive, by the gaps in their numbers; counted while the topic has one
            publisher.
        left_out: that arrived, and were not written because memory ran short.
    """

    received: int = 0
    written: int = 0
    lost: int = 0
    left_out: int = 0
    _last: int | None = None

    @property
    def missing(self) -> int:
        """Messages that were published and are not in the bag."""
        return self.lost + self.left_out

    def receive(self, number: int | None, *, alone: bool) -> None:
        """Count a message that arrived.

        Args:
            number: its publisher's; None where the middleware states none.
            alone: whether the topic has one publisher.
        """
        self.received += 1
        if number is None or not alone:
            self._last = None
            return
        if self._last is not None and 1 < number - self._last < _LARGEST_GAP:
            self.lost += number - self._last - 1
        self._last = number

    def recover(self) -> None:
        """A message that did not arrive was kept elsewhere."""
        self.received += 1
        self.lost = max(0, self.lost - 1)

    def pass_over(self) -> None:
        """A message arrived that is not to be recorded: the gap it leaves is no loss."""
        self._last = None

    def text(self) -> str:
        """As the bag and diagnostics state it."""
        return f"received {self.received}, written {self.written}, lost {self.lost}, left out {self.left_out}"


def count_facts(counts: Mapping[str, TopicCount]) -> dict[str, str]:
    """Facts of a bag: what became of each topic's messages."""
    return {FACT + topic: count.text() for topic, count in sorted(counts.items()) if count.received}


def stated_counts(facts: Mapping[str, str]) -> dict[str, TopicCount]:
    """The counts that a bag states, by topic; one that cannot be read is left out."""
    found: dict[str, TopicCount] = {}
    for key, text in facts.items():
        words = text.replace(",", "").split()
        numbers = [int(w[:18]) for w in words if w.isascii() and w.isdecimal()]
        if key.startswith(FACT) and len(numbers) == 4:
            found[key.removeprefix(FACT)] = TopicCount(*numbers)
    return found
