"""Which files make up a bag, and how each is opened: MCAP or sqlite3, compressed by file, by message, or not."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.formats.bag_file import BagFile
from mbd_bag.formats.packed import SUFFIX, PackedMessages, unpack
from mbd_bag.formats.sqlite_file import FIRST_BYTES, SqliteFile
from mbd_bag.storage.mcap_file import McapFile

_STORED = (".mcap", ".db3", ".mcap" + SUFFIX, ".db3" + SUFFIX)
_STORAGES = ("mcap", "sqlite3")
_MODES = ("", "none", "file", "message", "storage")


@dataclass
class OpenedBag:
    """Files of a bag, and where those lie that had to be unpacked, for as long as this is held."""

    files: tuple[BagFile, ...]
    unpacked: TemporaryDirectory[str] | None = None


def stored_files(folder: Path) -> list[Path]:
    """The files in a folder that rosbag2 could have written, in the order recorded."""
    if not folder.is_dir():
        return []
    return sorted((p for p in folder.iterdir() if p.name.endswith(_STORED)), key=_number)


def _number(path: Path) -> tuple[int, str]:
    match = re.search(r"_(\d+)$", path.name.partition(".")[0])
    return (int(match[1][:18]) if match else -1, path.name)


def open_bag(path: Path, metadata: Mapping[str, Any] | None, problems: list[str]) -> OpenedBag:
    """Open the files of a bag.

    Args:
        path: its folder, or one file.
        metadata: what its metadata.yaml states; None when it has none.
        problems: what is missing is added to it, one sentence each.

    Raises:
        BagError: there is no bag, or it is of another kind.
    """
    if not path.exists():
        raise BagError(f"there is no bag {path}; give the folder a `recorder` wrote, or one .mcap file")
    if path.is_file():
        return _open_all([path], "")
    if metadata is not None:
        storage, mode = metadata["storage_identifier"], metadata["compression_mode"]
        if storage not in _STORAGES or mode not in _MODES:
            raise BagError(
                f"{path} is stored as '{storage}', compressed by '{mode or 'nothing'}'; expected "
                f"{' or '.join(_STORAGES)}, compressed by file or message. Convert it: ros2 bag convert"
            )
        names = metadata["relative_file_paths"]
        if len(set(names)) < len(names):
            raise BagError(f"{path}/metadata.yaml names a file twice; remove it to read the bag's files alone")
        return _open_all([path / name for name in names], mode)
    found = stored_files(path)
    if not found:
        raise BagError(f"{path} is no bag: it has no metadata.yaml, and holds no .mcap or .db3 file")
    problems.append(
        f"{path} has no metadata.yaml: its recorder was killed (`repair` makes a complete copy for ros2 bag)"
    )
    filled = [p for p in found if p.stat().st_size]
    problems += [f"{p.name} is empty (0 bytes)" for p in found if p not in filled]
    return _open_all(filled or found[:1], "")


def _open_all(paths: list[Path], mode: str) -> OpenedBag:
    unpacked: TemporaryDirectory[str] | None = None
    files: list[BagFile] = []
    for path in paths:
        at = path
        if path.name.endswith(SUFFIX):
            unpacked = unpacked or TemporaryDirectory(prefix="mbd_bag_")
            at = unpack(path, Path(unpacked.name))
        file = _open_one(at)
        files.append(PackedMessages(file) if mode == "message" else file)
    return OpenedBag(tuple(files), unpacked)


def _open_one(path: Path) -> BagFile:
    if path.is_file():
        with path.open("rb") as stream:
            if stream.read(len(FIRST_BYTES)) == FIRST_BYTES or path.suffix == ".db3":
                return SqliteFile(path)
    return McapFile(path)
