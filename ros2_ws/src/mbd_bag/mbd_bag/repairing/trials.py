"""Bags damaged at random, and how much of what stayed intact `repair` keeps."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mbd_bag.errors import BagError
from mbd_bag.repairing.trial_bags import (
    MessageIdentity,
    PlacedMessage,
    TrialBag,
    as_recorded,
    as_sqlite,
    identity_of,
    mcap_bag,
    sqlite_bag,
)
from mbd_bag.storage.bag import Bag
from mbd_bag.tools.repair import problems_of, repair


@dataclass(frozen=True)
class RepairTrial:
    """One damaged bag.

    Attributes:
        damage: what was done to it.
        messages: in it before.
        intact: of them in chunks or pages that were not touched.
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
    altered: int


def mcap_trials(bags: Iterable[Path], number: int, seed: int, folder: Path) -> Iterator[RepairTrial]:
    """So many trials over the bags of MCAP files in turn, each as it lies and as a recorder writes it.

    Args:
        bags: intact ones.
        number: of trials.
        seed: of the damage.
        folder: for copies; it must be empty.
    """
    pairs = ((mcap_bag(bag), mcap_bag(as_recorded(bag, folder / f"recorded_{k}"))) for k, bag in enumerate(bags))
    return _trials([bag for pair in pairs for bag in pair], number, seed, folder)


def sqlite_trials(bags: Iterable[Path], number: int, seed: int, folder: Path) -> Iterator[RepairTrial]:
    """The same over the bags stored as sqlite3 before; every second cut is at the border of a page."""
    stored = [sqlite_bag(as_sqlite(bag, folder / f"stored_{k}")) for k, bag in enumerate(bags)]
    return _trials(stored, number, seed, folder)


def _trials(bags: Sequence[TrialBag], number: int, seed: int, folder: Path) -> Iterator[RepairTrial]:
    rng = np.random.default_rng(seed)
    for k in range(number):
        bag = bags[k % len(bags)]
        yield repair_trial(bag, *damaged_bytes(bag.file.read_bytes(), bag.page, rng), folder)


def damaged_bytes(data: bytes, page: int, rng: np.random.Generator) -> tuple[bytes, str]:
    """A file's bytes with 1 to 20 of them flipped, and in every second one the end cut off.

    Args:
        data: of the file.
        page: size of its pages [byte]: every second cut is at a border of them; 0 where it has none.
        rng: decides.

    Returns:
        The damaged bytes, and what was done.
    """
    changed = bytearray(data)
    flips = sorted({int(k) for k in rng.integers(0, len(data), int(rng.integers(1, 21)))})
    for place in flips:
        changed[place] ^= int(rng.integers(1, 256))
    cut = int(rng.integers(len(data) // 10, len(data))) if rng.random() < 0.5 else len(data)
    damage = f"{len(flips)} flips" + (f", cut at {cut} of {len(data)}" * (cut < len(data)))
    if page and rng.random() < 0.5 and cut < len(data):
        cut -= cut % page
        damage += " (a page's border)"
    return bytes(changed[:cut]), damage


def repair_trial(bag: TrialBag, data: bytes, damage: str, folder: Path) -> RepairTrial:
    """Repair a copy of a bag with other bytes in its file's place, and count.

    Args:
        bag: an intact one.
        data: the damaged file; what is intact of it lies where it lay.
        damage: what was done to it.
        folder: for the copies; they are removed again.
    """
    touched = _touched_parts(bag, data)
    damaged = [m for m in bag.messages if m.parts & touched]
    everything = Counter(m.identity for m in bag.messages)
    intact = everything - Counter(m.identity for m in damaged)
    hurt, out = folder / "hurt", folder / "out"
    shutil.rmtree(hurt, ignore_errors=True)
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(bag.folder, hurt)
    (hurt / bag.file.name).write_bytes(data)
    noticed = bool(problems_of(hurt))
    read: Counter[MessageIdentity] = Counter()
    sizes: dict[MessageIdentity, int] = {}
    failure = ""
    try:
        repair(hurt, out)
        for message in Bag(out).messages():
            identity = identity_of(message)
            read[identity] += 1
            sizes[identity] = len(message.data)
    except BagError as error:
        failure = str(error)
    others = read - everything
    # A chunk has a checksum: of one that was touched nothing may be there.
    altered = sum(_is_altered(k, sizes[k], damaged) for k in others.elements()) if bag.page else 0
    altered = min(len(damaged), altered)
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


def _touched_parts(bag: TrialBag, data: bytes) -> set[tuple[int, int]]:
    """Of the parts that hold messages, those with a byte that is another or no longer there."""
    parts = np.array(sorted({part for m in bag.messages for part in m.parts}), dtype=np.int64).reshape(-1, 2)
    before = np.frombuffer(bag.file.read_bytes(), dtype=np.uint8)[: len(data)]
    others = np.flatnonzero(before != np.frombuffer(data, dtype=np.uint8)[: len(before)])
    hit = np.searchsorted(others, parts[:, 0]) < np.searchsorted(others, parts[:, 1])
    return {(int(a), int(b)) for a, b in parts[hit | (parts[:, 1] > len(data))]}


def _is_altered(identity: MessageIdentity, size: int, damaged: Sequence[PlacedMessage]) -> bool:
    """Whether a message is one of those that were hit, by what of it is as before."""
    topic, time, digest = identity
    return any(
        m.identity[1] == time or m.identity[2] == digest or (m.identity[0] == topic and m.size == size) for m in damaged
    )
