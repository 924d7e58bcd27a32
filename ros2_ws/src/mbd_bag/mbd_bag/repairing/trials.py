"""Bags damaged at random, and how much of what stayed intact `repair` keeps."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np

from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.mcap_file import McapFile
from mbd_bag.tools.repair import problems_of, repair


@dataclass(frozen=True)
class RepairTrial:
    """One damaged bag.

    Attributes:
        damage: what was done to it.
        messages: in it before.
        intact: of them in chunks that were not touched.
        kept: of those in the copy.
        invented: messages of the copy that the bag never held.
        noticed: whether anything was said before repairing.
        failure: why there is no copy; "" when there is one.
        altered: messages of the copy in whose bytes damage lies that nothing tells, as sqlite3 has no checksums.
    """

    damage: str
    messages: int
    intact: int
    kept: int
    invented: int
    noticed: bool
    failure: str
    altered: int = 0


def _identity(topic: str, log_time: int, data: bytes) -> tuple[str, int, bytes]:
    return topic, log_time, sha256(data).digest()[:12]


@lru_cache(maxsize=16)  # a few bags are damaged over and over
def messages_in_chunks(file: Path) -> list[tuple[int, int, Counter[tuple[str, int, bytes]]]]:
    """(start, end, messages) of each chunk of an intact file; offsets in bytes."""
    opened = McapFile(file)
    rows = []
    for chunk in sorted(opened.contents.chunks, key=lambda c: c.chunk_start_offset):
        found = opened.chunk_messages(chunk)
        held = Counter(_identity(m.topic, m.log_time, m.data) for m in found)
        rows.append((chunk.chunk_start_offset, chunk.chunk_start_offset + chunk.chunk_length, held))
    return rows


def as_recorded(bag: Path, out: Path, period: int = 500_000_000) -> Path:
    """A bag as a recorder writes it: its chunks end twice a second [ns]. Returns the folder written.

    Args:
        bag: of any chunks.
        out: folder to write.
        period: after which a chunk ends [ns].
    """
    source = Bag(bag)
    definitions = {s.name: s.data.decode() for f in source.files for s in f.contents.schemas.values()}
    with BagWriter(out) as writer:
        writer.add_facts(source.facts)
        flushed = source.start
        for topic in source.topics:
            if topic.count:
                record = TopicRecord(topic.name, topic.msgtype, qos=source.offered_qos(topic.name))
                writer.add_topic(record, definitions[topic.msgtype])
        for message in source.messages():
            writer.write(message.topic, message.log_time, message.data, message.publish_time)
            if message.log_time - flushed >= period:
                writer.flush()
                flushed = message.log_time
    return out


def damaged_bytes(data: bytes, rng: np.random.Generator) -> tuple[bytes, list[int], str]:
    """A file's bytes with 1 to 20 of them flipped, and in every second one the end cut off.

    Args:
        data: of the file.
        rng: decides.

    Returns:
        The damaged bytes, where they were flipped [byte], and what was done.
    """
    changed = bytearray(data)
    flips = sorted({int(k) for k in rng.integers(0, len(data), int(rng.integers(1, 21)))})
    for place in flips:
        changed[place] ^= int(rng.integers(1, 256))
    cut = int(rng.integers(len(data) // 10, len(data))) if rng.random() < 0.5 else len(data)
    return bytes(changed[:cut]), flips, f"{len(flips)} flips" + (f", cut at {cut} of {len(data)}" * (cut < len(data)))


def repair_trial(bag: Path, rng: np.random.Generator, folder: Path) -> RepairTrial:
    """Damage a copy of a bag of one MCAP file, repair it, and count.

    Args:
        bag: an intact bag.
        rng: decides on the damage.
        folder: for the copies; they are removed again.
    """
    (file,) = sorted(bag.glob("*.mcap"))
    chunks = messages_in_chunks(file)
    data, flips, damage = damaged_bytes(file.read_bytes(), rng)
    intact: Counter[tuple[str, int, bytes]] = Counter()
    for start, end, held in chunks:
        if end <= len(data) and not any(start <= k < end for k in flips):
            intact.update(held)
    everything: Counter[tuple[str, int, bytes]] = Counter()
    for _, _, held in chunks:
        everything.update(held)
    hurt, out = folder / "hurt", folder / "out"
    shutil.rmtree(hurt, ignore_errors=True)
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(bag, hurt)
    (hurt / file.name).write_bytes(data)
    noticed = bool(problems_of(hurt))
    try:
        repair(hurt, out)
        read = Counter(_identity(m.topic, m.log_time, m.data) for m in Bag(out).messages())
        failure = ""
    except BagError as error:
        read, failure = Counter(), str(error)
    return RepairTrial(
        damage=damage,
        messages=everything.total(),
        intact=intact.total(),
        kept=(intact & read).total(),
        invented=(read - everything).total(),
        noticed=noticed,
        failure=failure if intact else "",
    )


def repair_trials(bags: Iterable[Path], number: int, seed: int, folder: Path) -> Iterable[RepairTrial]:
    """So many trials over the bags of MCAP files in turn, each as it lies and as a recorder writes it.

    Args:
        bags: intact ones.
        number: of trials.
        seed: of the damage.
        folder: for copies; it must be empty.
    """
    rng = np.random.default_rng(seed)
    all_bags = [b for k, bag in enumerate(bags) for b in (bag, as_recorded(bag, folder / f"recorded_{k}"))]
    for k in range(number):
        yield repair_trial(all_bags[k % len(all_bags)], rng, folder)
