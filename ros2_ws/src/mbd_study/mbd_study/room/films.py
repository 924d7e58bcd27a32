"""The films of the room that lie beside a session's bag, and the test signals that are marked in it."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.storage.bag import Bag
from mbd_model.room.recording import SIGNAL_MARKER

NOTE = "mbd_msgs/msg/WizardNote"


def films_beside(bag: Path) -> tuple[Path, ...]:
    """``room_<n>.webm`` beside a bag, in order of n."""
    found = [p for p in bag.resolve().parent.glob("room_*.webm") if p.stem.removeprefix("room_").isdecimal()]
    return tuple(sorted(found, key=lambda p: int(p.stem.removeprefix("room_"))))


def marked_signals(bag: Bag) -> dict[str, dict[int, float]]:
    """Of each film, by name: number of a test signal -> its moment in the bag [s, session clock]."""
    topics = {t.name for t in bag.topics if t.msgtype == NOTE and t.count}
    found: dict[str, dict[int, float]] = {}
    if not topics:
        return found
    for _, note in bag.decoded(topics):
        name, _, number = str(note.text).rpartition(" ")
        if note.marker == SIGNAL_MARKER and name and number.isdecimal():
            at = note.header.stamp.sec + note.header.stamp.nanosec * 1e-9
            found.setdefault(name, {})[int(number)] = at
    return found
