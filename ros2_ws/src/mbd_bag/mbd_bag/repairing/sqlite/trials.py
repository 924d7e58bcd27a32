"""Sqlite3 bags damaged at random, and how much of what lay on intact pages `repair` keeps."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter

from mbd_bag.errors import BagError
from mbd_bag.repairing.sqlite.pages import Pages, open_pages
from mbd_bag.repairing.sqlite.rows import MessageRow, find_rows, follow, record_bytes
from mbd_bag.repairing.trials import RepairTrial, damaged_bytes
from mbd_bag.storage.bag import Bag
from mbd_bag.tools.repair import problems_of, repair


@dataclass(frozen=True)
class PlacedMessage:
    """One message, and the pages of its file that hold it.

    Attributes:
        topic: absolute name.
        time: when it was recorded [ns].
        digest: of its data.
        size: of its data [byte].
        pages: numbers, from 1.
    """

    topic: str
    time: int
    digest: bytes
    size: int
    pages: frozenset[int]

    @property
    def identity(self) -> tuple[str, int, bytes]:
        """What no other message of a bag shares, but its copies."""
        return self.topic, self.time, self.digest


def as_sqlite(bag: Path, out: Path) -> Path:
    """Store a bag as rosbag2 did by default up to Humble, in one sqlite3 file, by rosbags. Returns the folder.

    Args:
        bag: of any storage.
        out: folder to write; it must not exist.
    """
    source = Bag(bag)
    with RosbagsWriter(out, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            t.name: writer.add_connection(t.name, t.msgtype, typestore=source.decoder.store(t.msgtype))
            for t in source.topics
            if t.count
        }
        for message in source.messages():
            writer.write(connections[message.topic], message.log_time, message.data)
    return out


@lru_cache(maxsize=16)  # a few bags are damaged over and over
def placed_messages(file: Path) -> tuple[PlacedMessage, ...]:
    """Every message of an intact file, with its pages; raises BagError when sqlite reads other ones."""
    pages = open_pages(file)
    found = find_rows(pages)
    placed: list[PlacedMessage] = []
    for row in found.messages:
        own = _pages_of(pages, row)
        data = (record_bytes(pages, row.leaf, row.cell) or b"")[row.offset :]
        placed.append(PlacedMessage(found.topics[row.topic].name, row.time, _digest(data), len(data), own))
    by_sqlite = Counter((m.topic, m.log_time, _digest(m.data)) for m in Bag(file).messages())
    if by_sqlite != Counter(m.identity for m in placed):
        raise BagError(f"{file}: sqlite reads other messages than its pages hold")
    return tuple(placed)


def _pages_of(pages: Pages, row: MessageRow) -> frozenset[int]:
    own = {row.page}
    follow(pages, row.cell, lambda number, _: own.add(number))
    return frozenset(own)


def _digest(data: bytes) -> bytes:
    return sha256(data).digest()[:12]


def sqlite_trial(bag: Path, rng: np.random.Generator, folder: Path) -> RepairTrial:
    """Damage a copy of a bag of one sqlite3 file, repair it, and count.

    Args:
        bag: an intact bag.
        rng: decides on the damage; every second cut is at the border of a page.
        folder: for the copies; they are removed again.
    """
    (file,) = bag.glob("*.db3")
    data, _, damage = damaged_bytes(file.read_bytes(), rng)
    if rng.random() < 0.5 and len(data) < file.stat().st_size:
        size = open_pages(file).size
        data = data[: len(data) // size * size]
        damage += " (a page's border)"
    return trial_of(bag, data, damage, folder)


def trial_of(bag: Path, data: bytes, damage: str, folder: Path) -> RepairTrial:
    """Repair a copy of a bag of one sqlite3 file with other bytes in its place, and count.

    Args:
        bag: an intact bag.
        data: the damaged file; its pages lie where they lay, as far as it goes.
        damage: what was done to it.
        folder: for the copies; they are removed again.
    """
    (file,) = bag.glob("*.db3")
    placed = placed_messages(file)
    size = open_pages(file).size
    before = np.frombuffer(file.read_bytes(), dtype=np.uint8)[: len(data)]
    hit = {int(k) // size + 1 for k in np.flatnonzero(before != np.frombuffer(data, dtype=np.uint8))}
    whole = len(data) // size
    intact = Counter(m.identity for m in placed if not m.pages & hit and max(m.pages) <= whole)
    everything = Counter(m.identity for m in placed)
    hurt, out = folder / "hurt", folder / "out"
    shutil.rmtree(hurt, ignore_errors=True)
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(bag, hurt)
    (hurt / file.name).write_bytes(data)
    noticed = bool(problems_of(hurt))
    read: Counter[tuple[str, int, bytes]] = Counter()
    failure = ""
    sizes: dict[tuple[str, int, bytes], int] = {}
    try:
        repair(hurt, out)
        for m in Bag(out).messages():
            identity = m.topic, m.log_time, _digest(m.data)
            read[identity] += 1
            sizes[identity] = len(m.data)
    except BagError as error:
        failure = str(error)
    others = read - everything
    damaged = [m for m in placed if m.pages & hit]
    altered = min(len(damaged), sum(_is_altered(k, sizes[k], damaged) for k in others.elements()))
    return RepairTrial(
        damage=damage,
        messages=everything.total(),
        intact=intact.total(),
        kept=(intact & read).total(),
        invented=others.total() - altered,
        noticed=noticed,
        failure=failure if intact else "",
        altered=altered,
    )


def _is_altered(identity: tuple[str, int, bytes], size: int, hit: list[PlacedMessage]) -> bool:
    """Whether a message is one of those that were hit, by what of it is as before."""
    topic, time, digest = identity
    return any(m.time == time or m.digest == digest or (m.topic == topic and m.size == size) for m in hit)


def sqlite_trials(bags: Iterable[Path], number: int, seed: int, folder: Path) -> Iterator[RepairTrial]:
    """So many trials over the bags in turn, each stored as sqlite3 before.

    Args:
        bags: intact ones.
        number: of trials.
        seed: of the damage.
        folder: for copies; it must be empty.
    """
    rng = np.random.default_rng(seed)
    stored = [as_sqlite(bag, folder / f"stored_{k}") for k, bag in enumerate(bags)]
    for k in range(number):
        yield sqlite_trial(stored[k % len(stored)], rng, folder)
