"""Names of people and sessions in texts: found whatever their case, as a word of their own, and replaced."""

from __future__ import annotations

import re
from collections.abc import Iterable

REPLACEMENT = "[name]"


class NameFinder:
    """Finds names.

    Args:
        names: of participants and sessions, and whatever else shall not be read; empty ones say nothing.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self.names = tuple(sorted({n.strip() for n in names if n.strip()}, key=lambda n: (-len(n), n)))
        # Between letters and digits a name is part of another word: "anna" is not in "annalen", "p1" not in "p12".
        either = "|".join(re.escape(n) for n in self.names)
        self._pattern = re.compile(rf"(?<![^\W_])(?:{either})(?![^\W_])", re.IGNORECASE) if self.names else None

    def within(self, text: str) -> bool:
        """Whether a name is in a text."""
        return self._pattern is not None and self._pattern.search(text) is not None

    def without(self, text: str) -> str:
        """The text with `REPLACEMENT` for each name."""
        return text if self._pattern is None else self._pattern.sub(REPLACEMENT, text)

    def maybe_in(self, data: bytes) -> bool:
        """Whether a name may be in a message's bytes: a look that is quick, and never misses one."""
        lower = data.lower()
        # Of a letter beyond ASCII the capital has other bytes; then the message has to be read.
        return any(not n.isascii() or n.lower().encode() in lower for n in self.names)
