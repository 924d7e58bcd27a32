"""Which messages of the session's own a bag holds, by their keys: what is spooled and not among them is missing.

A line of JSON is added whenever the bag's file was flushed, so after a kill the file holds those of the lines, and
maybe a few more; after a power cut maybe a few less. How many it holds of each topic tells.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from mbd_bag.spool.spool_file import Key, SpooledMessage

_PASSED = "passed over"  # in place of a file's name


class KeyLog:
    """Adds lines to the log of one start of a session; where the disk takes none, what it held is known of no message.

    Args:
        path: of the log; its folder is made when missing.

    Raises:
        OSError: it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("ab", buffering=0)
        # A line that a killed recorder did not finish, or a full disk did not take, ends where the next begins.
        self._cut = self._file.tell() > 0

    def add(self, file: str, keys: list[Key]) -> None:
        """These messages are in that file of the bag, in this order."""
        by_topic: dict[str, list[tuple[int, int]]] = {}
        for topic, source, number in keys:
            by_topic.setdefault(topic, []).append((source, number))
        if by_topic:
            line = ("\n" * self._cut + json.dumps({"file": file, "keys": by_topic}) + "\n").encode()
            self._cut = True
            self._cut = self._file.write(line) < len(line)

    def pass_over(self, keys: list[Key]) -> None:
        """These messages are no part of the recording."""
        self.add(_PASSED, keys)

    def close(self) -> None:
        """Close it."""
        self._file.close()


def keys_path(folder: Path, run: str) -> Path:
    """The log of one start of a session."""
    return folder / f"{run or 'session'}.written"


def logged_keys(path: Path) -> dict[str, dict[str, list[Key]]]:
    """The keys by file of the bag and topic; {} when there is no log. A line that cannot be read is passed over."""
    found: dict[str, dict[str, list[Key]]] = {}
    try:
        lines = path.read_bytes().splitlines()
    except OSError:
        return {}
    for line in lines:
        try:
            entry = json.loads(line)
            of_file = found.setdefault(str(entry["file"]), {})
            for topic, keys in entry["keys"].items():
                of_file.setdefault(topic, []).extend((topic, int(source), int(number)) for source, number in keys)
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
    return found


def known_keys(
    logged: Mapping[str, Mapping[str, list[Key]]],
    counts: Mapping[str, Mapping[str, int]],
    spooled: list[SpooledMessage],
) -> set[Key]:
    """The keys of messages that a bag holds, or is not to hold.

    Args:
        logged: as `logged_keys` has them.
        counts: how many messages each file of the bag holds, by topic.
        spooled: what the journal holds, oldest first.
    """
    known = {key for keys in logged.get(_PASSED, {}).values() for key in keys}
    more: dict[str, int] = {}
    for file, by_topic in logged.items():
        if file == _PASSED:
            continue
        for topic, keys in by_topic.items():
            there = counts.get(file, {}).get(topic, 0)
            # Fewer: the last of them were cut off. More: its recorder was killed before it could say so.
            known |= set(keys[:there])
    for file, by_count in counts.items():
        for topic, there in by_count.items():
            unsaid = there - len(logged.get(file, {}).get(topic, []))
            if unsaid > 0:
                more[topic] = more.get(topic, 0) + unsaid
    for message in spooled:
        if message.key not in known and more.get(message.topic, 0) > 0:
            more[message.topic] -= 1
            known.add(message.key)
    return known
