"""Folders that results are written to, and files in them that cannot be used."""

from __future__ import annotations

from pathlib import Path

from mbd_model.errors import MbdError


def make_folder(folder: Path) -> Path:
    """Make a folder and those above it when they are missing; raises MbdError when that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MbdError(
            f"the folder {folder} cannot be made ({error.strerror or error}): give one that this user may write"
        ) from error
    return folder


def set_aside(path: Path) -> str:
    """Move a file (or what stands in its place) out of the way, and never over another; returns a sentence on it."""
    number = 0
    while (aside := path.with_suffix(f".broken{number or ''}")).exists():
        number += 1
    try:
        path.rename(aside)
    except OSError as error:
        return f"It could not be moved away either: {error}"
    return f"It was moved to {aside.name}"
