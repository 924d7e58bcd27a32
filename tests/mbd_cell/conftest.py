"""Makes the shipped scenes importable; pytest's importlib mode does not put test folders on the path."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def config() -> Path:
    """Folder of the shipped scene files."""
    return Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"
