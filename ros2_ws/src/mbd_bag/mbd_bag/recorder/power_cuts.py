"""How much of a recording a power cut costs, simulated: of the bag's files is left what the disk was made to keep.

A writer gets messages at a session's rate while cuts fall at random moments. Nothing is cut in truth: of each moment is
noted how many bytes of which file were synced. What those hold is read afterwards.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter, bag_files
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.mcap_file import McapFile

_NOTE, _PICTURE = "std_msgs/msg/String", "sensor_msgs/msg/CompressedImage"
_RATE = 100.0  # [1/s] of small messages; of pictures one in three
_FIRST = 2.5  # [s] after the begin, before which no cut falls: nothing is said of a bag that has just been opened


@dataclass(frozen=True)
class PowerCut:
    """One moment, and what a disk without power would hold of the bag then.

    Attributes:
        moment: of the cut, by a steady clock [ns].
        file: which was being written; those before it are kept.
        synced: how much of it the disk keeps [byte].
        loss: from the last message kept to the cut [s].
    """

    moment: int
    file: Path
    synced: int
    loss: float = float("nan")


def power_cuts(
    folder: Path, cuts: int, seconds: float, rng: np.random.Generator, *, picture: int, file_size: int = 256 << 20
) -> list[PowerCut]:
    """Record for some time and cut the power at random moments.

    Args:
        folder: of the bag, which is written and stays; it must not exist.
        cuts: how many.
        seconds: to record; at least 4.
        rng: decides on the moments and the pictures.
        picture: size of a picture [byte].
        file_size: of a file after which the bag's next begins [byte].
    """
    writer = BagWriter(folder)
    thread = WritingThread(writer, file_size=file_size)
    for topic, kind in (("/note", _NOTE), ("/picture", _PICTURE)):
        thread.add_topic(TopicRecord(topic, kind, type_hash(kind)), full_definition(kind))
    pictures = [rng.bytes(picture) for _ in range(8)]
    begin = time.monotonic_ns()
    moments = [begin + round(1e9 * t) for t in np.sort(rng.uniform(_FIRST, seconds, cuts))]
    seen: list[PowerCut] = []
    sent = 0
    while len(seen) < cuts:
        now = time.monotonic_ns()
        if moments[len(seen)] <= now:
            seen.append(PowerCut(now, *writer.synced))
        elif now >= begin + round(1e9 * sent / _RATE):
            topic, data = ("/picture", pictures[sent % 8]) if sent % 3 == 0 else ("/note", bytes(40))
            thread.write(topic, now, data)
            sent += 1
        else:
            time.sleep(0.001)  # the pace of a session: neither a message nor a cut is due
    thread.close()
    chunks = {file: McapFile(file).contents.chunks for file in bag_files(folder)}

    def loss(cut: PowerCut) -> float:
        left = _left(cut)
        kept = (c for file, n in left.items() for c in chunks[file] if c.chunk_start_offset + c.chunk_length <= n)
        return (cut.moment - max((c.message_end_time for c in kept), default=0)) / 1e9

    return [replace(cut, loss=loss(cut)) for cut in seen]


def _left(cut: PowerCut) -> dict[Path, int]:
    """How much a cut leaves of each file [byte]."""
    files = bag_files(cut.file.parent)
    before = files[: files.index(cut.file)]
    return {file: file.stat().st_size for file in before} | {cut.file: cut.synced}


def after_cut(cut: PowerCut, out: Path) -> Path:
    """The bag as it is after a cut; returns its folder.

    Args:
        cut: of its recording.
        out: folder to write; it must not exist.
    """
    out.mkdir(parents=True)
    for number, (file, size) in enumerate(_left(cut).items()):
        (out / f"{out.name}_{number}.mcap").write_bytes(file.read_bytes()[:size])
    return out
