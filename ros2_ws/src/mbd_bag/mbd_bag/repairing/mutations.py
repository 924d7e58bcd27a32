"""Bags changed as accident and malice would change them, each by a seed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zstandard
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

Rng = np.random.Generator
Mutation = Callable[[Path, Rng], None]
# What may stand where metadata.yaml states something else.
_VALUES = (
    "[1, 2]", "{a: 1}", "9" * 6000, "2020-99-99", "''", "~", "-5", "1e999", ".nan", "*unknown", "!!python/name:os.x",
    "[" * 5000, "{a: " * 300 + "1" + "}" * 300, "&a [*a]", "'\\0'", '"\\uD800"', "../../../etc/passwd",
)  # fmt: skip


def _mcap(folder: Path) -> Path:
    return next(iter(sorted(folder.glob("*.mcap"))))


def _edited(folder: Path, edit: Callable[[bytearray], object]) -> None:
    data = bytearray(_mcap(folder).read_bytes())
    edit(data)
    _mcap(folder).write_bytes(data)


def flip(folder: Path, rng: Rng) -> None:
    """Flip up to 20 bytes of the file."""

    def edit(data: bytearray) -> None:
        for place in rng.integers(0, len(data), int(rng.integers(1, 21))):
            data[place] ^= int(rng.integers(1, 256))

    _edited(folder, edit)


def flip_near_an_end(folder: Path, rng: Rng) -> None:
    """Flip a byte among the first or last 3 000: header, declarations, index."""

    def edit(data: bytearray) -> None:
        place = int(rng.integers(0, min(3000, len(data))))
        data[place if rng.random() < 0.5 else len(data) - 1 - place] ^= int(rng.integers(1, 256))

    _edited(folder, edit)


def cut(folder: Path, rng: Rng) -> None:
    """Cut the file anywhere."""
    _edited(folder, lambda data: data.__delitem__(slice(int(rng.integers(0, len(data))), None)))


def take_out(folder: Path, rng: Rng) -> None:
    """Take some bytes out of the middle."""

    def edit(data: bytearray) -> None:
        place = int(rng.integers(0, len(data)))
        del data[place : place + int(rng.integers(1, 5000))]

    _edited(folder, edit)


def put_in(folder: Path, rng: Rng) -> None:
    """Put a copy of some bytes of the file elsewhere into it."""

    def edit(data: bytearray) -> None:
        place, other = (int(k) for k in rng.integers(0, len(data), 2))
        data[other:other] = data[place : place + int(rng.integers(1, 5000))]

    _edited(folder, edit)


def large_number(folder: Path, rng: Rng) -> None:
    """Write a large number over any eight bytes: some of them are lengths and counts."""

    def edit(data: bytearray) -> None:
        near = bool(rng.random() < 0.7)
        place = int(rng.integers(0, min(4000, len(data) - 8) if near else len(data) - 8))
        place = place if rng.random() < 0.5 else len(data) - 8 - place
        data[place : place + 8] = int(rng.choice([2**31 - 1, 2**32 - 1, 2**40, 2**63 - 1])).to_bytes(8, "little")

    _edited(folder, edit)


def state_otherwise(folder: Path, rng: Rng) -> None:
    """Change a value of metadata.yaml."""
    path = folder / "metadata.yaml"
    lines = path.read_text().splitlines()
    number = int(rng.integers(0, len(lines)))
    key, _, _ = lines[number].partition(":")
    lines[number] = f"{key}: {_VALUES[int(rng.integers(0, len(_VALUES)))]}"
    path.write_text("\n".join(lines))


def lose_lines(folder: Path, rng: Rng) -> None:
    """Take some lines out of metadata.yaml, or cut it."""
    path = folder / "metadata.yaml"
    lines = path.read_text().splitlines()
    number = int(rng.integers(0, len(lines)))
    del lines[number : None if rng.random() < 0.3 else number + int(rng.integers(1, 20))]
    path.write_text("\n".join(lines))


def flip_metadata(folder: Path, rng: Rng) -> None:
    """Flip a byte of metadata.yaml."""
    path = folder / "metadata.yaml"
    data = bytearray(path.read_bytes())
    data[int(rng.integers(0, len(data)))] ^= int(rng.integers(1, 256))
    path.write_bytes(data)


def other_metadata(folder: Path, rng: Rng) -> None:
    """Put something else in the place of metadata.yaml."""
    path = folder / "metadata.yaml"
    path.unlink()
    aliases = "\n".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}' if k else 'x'] * 9)}]" for k in range(12))
    kinds = ("[" * 100_000, "- " * 50_000, aliases, "", "text", "\x00", "rosbag2_bagfile_information: [1]", "a: [")
    choice = int(rng.integers(0, len(kinds) + 1))
    if choice == len(kinds):
        path.mkdir()
    else:
        path.write_text(kinds[choice])


def hostile_definition(folder: Path, rng: Rng) -> None:
    """A file whose definitions ask for more than there is, or are none."""
    deep = "\n".join(f"{'=' * 80}\nMSG: p/T{k}\nT{k + 1}[1000] x" for k in range(8))
    texts = (
        b"string[4000000000] text\n",
        b"string text\n\xff\xfe",
        b"Note again\n" + b"=" * 80 + b"\nMSG: mbd_msgs/Note\nNote again\n",
        b"T0[1000] x\n" + deep.encode() + b"\n" + b"=" * 80 + b"\nMSG: p/T8\nint8 x\n",
        b"unknown_msgs/Type x\n",
        b"int32 class\n",
        b"string<=4000000000 text\nstring[] more\n",
        b"\n" * 2_000_000,
        b"{}[]((",
    )
    _mcap(folder).unlink()
    (folder / "metadata.yaml").unlink()
    with (folder / f"{folder.name}_0.mcap").open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE)
        writer.start(profile="ros2", library="hostile")
        schema = writer.register_schema("mbd_msgs/msg/WizardNote", "ros2msg", texts[int(rng.integers(0, len(texts)))])
        channel = writer.register_channel("/wizard/note", "cdr", schema)
        for number in range(3):
            writer.add_message(channel, number, b"\0\1\0\0" + rng.bytes(int(rng.integers(0, 60))), number)
        writer.finish()


def bomb(folder: Path, rng: Rng) -> None:
    """A few bytes that decompress to more than there is memory."""
    stated = int(rng.choice([2**20, 2**27, 2**31, 2**33]))
    packed = zstandard.compress(b"\0" * (1 << 26)) * 4
    body = b"".join(
        (
            b"\0" * 16, stated.to_bytes(8, "little"), b"\0" * 4, b"\4\0\0\0zstd", len(packed).to_bytes(8, "little"),
            packed,
        )
    )  # fmt: skip
    head = b"\x04\0\0\0ros2\x07\0\0\0hostile"
    data = b"\x89MCAP0\r\n\x01" + len(head).to_bytes(8, "little") + head
    (folder / "metadata.yaml").unlink()
    _mcap(folder).write_bytes(data + (b"\x06" + len(body).to_bytes(8, "little") + body) * int(rng.integers(1, 40)))


def lose_a_message(folder: Path, rng: Rng) -> None:
    """Take a message out of an uncompressed chunk, and leave index and counts as they were."""
    from mbd_bag.formats.chunks import RECORD_HEADER, take_apart
    from mbd_bag.repairing.unpacked_copy import rewrite_uncompressed

    rewrite_uncompressed(_mcap(folder))

    def edit(data: bytearray) -> None:
        place = data.index(b"\x06", 8 + RECORD_HEADER + int.from_bytes(data[9:17], "little"))
        begin = place + RECORD_HEADER + 8 + 8 + 8 + 4 + 4 + 8
        size = int.from_bytes(data[begin - 8 : begin], "little")
        found = take_apart(bytes(data[begin : begin + size]))
        offset = found.offsets[int(rng.integers(0, len(found.offsets)))]
        # Of another kind, which readers pass over: lengths and offsets stay.
        data[begin + offset] = 0x90
        data[begin - 16 : begin - 12] = b"\0" * 4  # no checksum

    _edited(folder, edit)


MUTATIONS: dict[str, Mutation] = {
    m.__name__.replace("_", " "): m
    for m in (
        flip, flip_near_an_end, cut, take_out, put_in, large_number, state_otherwise, lose_lines, flip_metadata,
        other_metadata, hostile_definition, bomb, lose_a_message,
    )
}  # fmt: skip


def mutate(bag: Path, out: Path, name: str, rng: Rng) -> None:
    """Copy a bag of one MCAP file, and change the copy.

    Args:
        bag: intact.
        out: the copy; removed first when it exists.
        name: one of MUTATIONS.
        rng: decides.
    """
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(bag, out)
    MUTATIONS[name](out, rng)
