"""What reads bytes of a bag, each for itself, to be given anything: `tools/fuzz`, and a seeded corpus in the tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mcap.records import Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.bag_file import BagFile
from mbd_bag.formats.bounded_yaml import bounded_yaml
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.sqlite_file import SqliteFile
from mbd_bag.repairing.intact_records import intact_records
from mbd_bag.repairing.sqlite.copying import copy_rows
from mbd_bag.repairing.stated_topics import complete_declarations
from mbd_bag.storage.decoding import Decoder
from mbd_bag.storage.mcap_file import McapFile

_MOST_MESSAGES = 1000  # decoded of one file
_LARGE = (2**16 - 1, 2**31 - 1, 2**32 - 1, 2**40, 2**63 - 1)


def read_mcap(data: bytes) -> None:
    """An MCAP file, all of it; raises BagError for one that is none."""
    _read_file(data, ".mcap", lambda path: McapFile(path, of_ros=False))


def read_sqlite(data: bytes) -> None:
    """A .db3 file, all of it; raises BagError for one that is none."""
    _read_file(data, ".db3", SqliteFile)


def _read_file(data: bytes, suffix: str, opened: Callable[[Path], BagFile]) -> None:
    with TemporaryDirectory(prefix="mbd_fuzz_") as folder:
        path = Path(folder) / f"bag{suffix}"
        path.write_bytes(data)
        file = opened(path)
        file.check()
        decoder = Decoder(file.contents.schemas.values())
        for number, message in enumerate(file.messages()):
            if number >= _MOST_MESSAGES:
                break
            if message.msgtype in decoder.texts:
                decoder.decode(message)


def read_damaged(data: bytes) -> None:
    """What is intact in an MCAP file: never raises."""
    view = memoryview(data)
    complete_declarations(view, intact_records(view), ())


def read_pages(data: bytes) -> None:
    """What is intact in a .db3 file: never raises."""
    with TemporaryDirectory(prefix="mbd_fuzz_") as folder:
        path = Path(folder) / "bag.db3"
        path.write_bytes(data)
        copy_rows(path, Path(folder) / "copy.mcap")


def read_yaml(data: bytes) -> None:
    """A metadata.yaml; raises BagError for what is no YAML within bounds."""
    try:
        bounded_yaml(data.decode())
    except ValueError as error:
        raise BagError(str(error)) from error


def read_message(data: bytes) -> None:
    """A definition of ``p/msg/T``, a byte 0, and a message of it; raises BagError for what is none."""
    text, _, body = data.partition(b"\0")
    decoder = Decoder([Schema(1, text, "ros2msg", "p/msg/T")])
    decoder.decode(BagMessage("/t", "p/msg/T", 0, 0, body))


TARGETS: dict[str, Callable[[bytes], None]] = {
    "mcap": read_mcap,
    "sqlite": read_sqlite,
    "damaged": read_damaged,
    "pages": read_pages,
    "yaml": read_yaml,
    "message": read_message,
}


def give(target: str, data: bytes) -> None:
    """Give bytes to one of TARGETS: what it raises but BagError in one sentence, is a fault."""
    try:
        TARGETS[target](data)
    except BagError as error:
        if "\n" in str(error):
            raise AssertionError(f"not one sentence: {error}") from error


def corpus(folder: Path) -> dict[str, list[tuple[str, bytes]]]:
    """(name, bytes) of the seeds of each target, which lie in folders named like it.

    "mcap" also serves "damaged", and "sqlite" also "pages".
    """
    found = {target: [(p.name, p.read_bytes()) for p in sorted((folder / target).glob("*"))] for target in TARGETS}
    found["damaged"] += found["mcap"]
    found["pages"] += found["sqlite"]
    return found


def mutated(seeds: list[tuple[str, bytes]], rng: np.random.Generator) -> Iterator[bytes]:
    """Without end: a seed, changed in one to four places.

    Args:
        seeds: (name, bytes) to begin from.
        rng: decides.
    """
    while seeds:
        data = bytearray(seeds[int(rng.integers(len(seeds)))][1])
        for _ in range(int(rng.integers(1, 5))):
            _change(data, seeds[int(rng.integers(len(seeds)))][1], rng)
        yield bytes(data)


def _change(data: bytearray, other: bytes, rng: np.random.Generator) -> None:
    at = int(rng.integers(len(data) + 1))
    length = int(rng.integers(1, 40))
    match int(rng.integers(6)):
        case 0 if at < len(data):
            data[at] ^= int(rng.integers(1, 256))
        case 1:
            del data[at : at + length]
        case 2:
            data[at:at] = rng.bytes(length)
        case 3:
            start = int(rng.integers(len(other) + 1))
            data[at : at + length] = other[start : start + length]
        case 4:
            size = int(rng.choice([2, 4, 8]))
            number = int(rng.choice(_LARGE)) & (256**size - 1)
            data[at : at + size] = number.to_bytes(size, "little")
        case _:
            del data[at:]
