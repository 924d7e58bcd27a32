"""What is recorded, on disk while it is recorded: appended and flushed, so that a killed node finds it again.

A file begins with one line of JSON and the bytes of what the recording began from; after that come blocks, each with a
line of JSON that says what and how long it is. A block that was cut off, as by a kill amid writing, is left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mbd_demonstration.gripper import GripperAction, GripperEvent
from mbd_demonstration.recording import Recording
from mbd_demonstration.samples import Samples

VERSION = 1
POSES, FINGER, EVENTS = "poses", "finger", "events"


@dataclass
class Journal:
    """Writes what a recording has that is not yet in its file.

    Attributes:
        path: of the file.
        written: how many rows of each series are in it.
    """

    path: Path
    written: dict[str, int] = field(default_factory=dict)

    @classmethod
    def begin(cls, path: Path, recording: Recording, origin: bytes, again: int, cuts: Sequence[float] = ()) -> Journal:
        """Begin a file in place of the one before.

        Args:
            path: of the file; its folder is there.
            recording: that begins.
            origin: what it began from, as its owner reads it again (a serialized message).
            again: first of the steps of ``origin`` that are shown again (0-based), -1 for none.
            cuts: last tool poses [s] before each end of a node that recorded it.
        """
        head = {"version": VERSION, "begin": recording.begin, "again": again, "cuts": [*cuts], "bytes": len(origin)}
        part = path.with_suffix(".part")
        part.write_bytes(json.dumps(head).encode() + b"\n" + origin)
        part.replace(path)
        return cls(path)

    def append(self, recording: Recording) -> int:
        """Write and flush what is new; returns how many rows that was."""
        blocks = []
        rows = 0
        for what, name, samples in _series(recording):
            before = self.written.get(name, 0)
            new = samples.table(since=before)
            if new.size:
                head = {"what": what, "name": name, "width": samples.width, "bytes": new.nbytes}
                blocks.append(json.dumps(head).encode() + b"\n" + new.astype("<f8").tobytes())
                self.written[name] = before + len(new)
                rows += len(new)
        if blocks:
            with self.path.open("ab") as stream:
                stream.write(b"".join(blocks))
        return rows

    def end(self) -> None:
        """The recording ended: nothing is to be gone on with."""
        self.path.unlink(missing_ok=True)

    def complete(self, recording: Recording) -> None:
        """The recording became a task: it is kept beside, for corrections that need where the tool went."""
        self.append(recording)
        self.path.replace(completed(self.path))


@dataclass(frozen=True)
class Found:
    """A recording that was cut off.

    Attributes:
        begin: when it began [s].
        origin: what it began from.
        again: first of its steps that were shown again (0-based), -1 for none.
        blocks: (what, name, rows (n, width)) in the order written.
        cuts: last tool poses [s] before each earlier end of a node that recorded it.
    """

    begin: float
    origin: bytes
    again: int
    blocks: tuple[tuple[str, str, np.ndarray], ...]
    cuts: tuple[float, ...] = ()

    def into(self, recording: Recording) -> Recording:
        """Put everything into a recording of the same scene."""
        for what, name, rows in self.blocks:
            if what == POSES:
                recording.poses.extend(rows)
            elif what == FINGER:
                recording.fingers.setdefault(name, Samples(rows.shape[1])).extend(rows)
            else:
                for stamp, action in rows.tolist():
                    recording.events.append(GripperEvent(stamp, GripperAction(int(action))))
        return recording


def completed(path: Path) -> Path:
    """Where the recording that became the task is kept, beside the file of one that runs."""
    return path.with_suffix(".recorded")


def found(path: Path) -> Found | None:
    """What a file of a killed node holds; None where there is no such file, or not even its beginning."""
    if not path.exists():
        return None
    data = path.read_bytes()
    line, _, rest = data.partition(b"\n")
    try:
        head = json.loads(line)
        size = int(head["bytes"])
        if head["version"] != VERSION or len(rest) < size:
            return None
        cuts = tuple(float(cut) for cut in head.get("cuts", ()))
        return Found(float(head["begin"]), rest[:size], int(head["again"]), tuple(_blocks(rest[size:])), cuts)
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return None


def _blocks(data: bytes) -> Iterator[tuple[str, str, np.ndarray]]:
    while data:
        line, newline, data = data.partition(b"\n")
        try:
            head = json.loads(line)
            size, width = int(head["bytes"]), int(head["width"])
            what, name = str(head["what"]), str(head["name"])
        except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
            return
        if not newline or len(data) < size:
            return
        if width < 1 or size % (8 * width):
            return
        yield what, name, np.frombuffer(data[:size], dtype="<f8").reshape(-1, width)
        data = data[size:]


def _series(recording: Recording) -> Iterator[tuple[str, str, Samples]]:
    """(what, name, samples) of each series."""
    yield POSES, POSES, recording.poses
    for name, samples in recording.fingers.items():
        yield FINGER, name, samples
    events = Samples(2)
    for event in recording.events:
        events.add(event.stamp, float(event.action))
    yield EVENTS, EVENTS, events
