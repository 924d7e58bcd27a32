"""Files in which a node keeps what must survive its end."""

from __future__ import annotations

from pathlib import Path


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
