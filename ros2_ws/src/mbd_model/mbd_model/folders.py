"""Folders that results are written to."""

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
