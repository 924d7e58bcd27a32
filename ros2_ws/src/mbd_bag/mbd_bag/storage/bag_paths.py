"""The bags below folders, without opening them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.formats.opening import stored_files
from mbd_bag.storage.bag_metadata import FILE_NAME


def is_bag(path: Path) -> bool:
    """Whether a path is taken for a bag: a file, or a folder that holds a bag's file or a metadata.yaml."""
    return path.is_file() or (path / FILE_NAME).exists() or bool(stored_files(path))


def bags_below(paths: Iterable[Path], *, superseded: bool = False) -> Iterator[Path]:
    """Each bag among these paths and below those that are folders of bags, in order of name.

    Args:
        paths: bags, or folders of bags.
        superseded: also those that were recorded again.

    Raises:
        BagError: a path has no bag.
    """
    for path in paths:
        if not path.exists() or is_bag(path):
            yield path
            continue
        found = False
        for folder in sorted(p for p in path.rglob("*") if p.is_dir() and is_bag(p)):
            if superseded or "_superseded_" not in folder.name:
                found = True
                yield folder
        if not found:
            raise BagError(f"there is no bag in or below {path}; give bags, or a folder of them")
