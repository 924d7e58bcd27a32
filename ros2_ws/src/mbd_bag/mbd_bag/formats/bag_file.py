"""What a file of a bag offers, whatever its format."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Protocol

from mbd_bag.formats.contents import BagMessage, FileContents


class BagFile(Protocol):
    """One file of a bag, opened for reading.

    Attributes:
        path: of the file.
        contents: what it holds.
    """

    path: Path
    contents: FileContents

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """Messages in order of log time.

        Args:
            topics: only of these; None: of all.
            start: only from this log time on [ns].
            end: only before this log time [ns].
        """
        ...

    def check(self) -> str:
        """Read all of the file; returns what is wrong with it, one sentence, "" when nothing is."""
        ...
