"""An episode recorded again: the bag of the first try is kept under another name, and marked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.storage.bag_writer import bag_files
from mbd_bag.storage.finishing import finish
from mbd_bag.storage.record_file import refuse_if_written

MARK = "superseded_by"


def is_superseded(facts: Mapping[str, str]) -> bool:
    """Whether a bag with these facts is a first try that was recorded again."""
    return bool(facts.get(MARK))


def supersede(folder: Path, distro: str = "jazzy") -> Path:
    """Mark a bag as recorded again and move it to ``<bag>_superseded_<number>``; returns that.

    A bag whose recorder died is completed first. Nothing is lost; tools that read many bags pass over it.

    Args:
        folder: the bag.
        distro: name of the ROS distribution.

    Raises:
        BagError: it is no bag of a recorder, or being written.
    """
    files = bag_files(folder) if folder.is_dir() else []
    filled = [p for p in files if p.stat().st_size]
    if not filled:
        raise BagError(f"{folder} holds no recorded bag that could be kept; remove it, or record under another name")
    refuse_if_written(files[-1])
    finish(folder, filled, {MARK: folder.name}, distro)
    number = 1
    while (kept := folder.with_name(f"{folder.name}_superseded_{number}")).exists():
        number += 1
    return folder.rename(kept)
