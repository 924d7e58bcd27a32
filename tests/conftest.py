"""Shared by all tests: private ROS domains and where the data kept outside the repository lies."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
# Wall-clock deadlines fail on a busy machine for no fault of the code; in CI the same cases every time.
settings.register_profile("mbd", deadline=None, max_examples=60, derandomize="CI" in os.environ)
settings.load_profile("mbd")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


@pytest.fixture
def ros_domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """A ROS domain no other test of this machine uses while the test runs (held by a file lock)."""
    locks = Path(os.environ.get("TMPDIR", "/tmp")) / f"mbd_ros_domains_{os.getuid()}"
    locks.mkdir(exist_ok=True)
    for domain in range(50, 100):
        with (locks / str(domain)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    pytest.fail("no free ROS domain between 50 and 99: are 50 tests running?")


@pytest.fixture
def shared_data() -> Path:
    """Folder ``shared`` beside the checkout; tests that need it skip when it is absent."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent: the real data is kept outside the repository")
    return folder
