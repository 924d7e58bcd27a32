"""Shared by all tests: private ROS domains and where the data kept outside the repository lies."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import overlay

overlay.complete()  # before anything of ours is imported

import mbd_cell  # noqa: F401  chooses how to render, before a test's own import of mujoco would
import numpy as np
import pytest
from hypothesis import settings
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bringup.domain import private_domain
from mbd_study.synthetic import CAMERA, SyntheticSession, session
from tiers import (  # noqa: F401  hooks
    pytest_collection_modifyitems,
    pytest_configure,
    pytest_runtest_protocol,
    pytest_xdist_make_scheduler,
)

ROOT = Path(__file__).resolve().parents[1]
# Wall-clock deadlines fail on a busy machine for no fault of the code; and a run is no game of chance: the same cases
# every time, unless new ones are looked for (MBD_EXPLORE=1).
settings.register_profile("mbd", deadline=None, max_examples=60, derandomize="MBD_EXPLORE" not in os.environ)
settings.load_profile("mbd")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
# A script's `&` has its children ignore SIGINT for good, and what the tests start would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """A ROS domain no other test or session of this machine uses while the test runs."""
    with private_domain() as domain:
        yield domain


@pytest.fixture
def shared_data() -> Path:
    """Folder ``shared`` beside the checkout; tests that need it skip when it is absent."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent: the real data is kept outside the repository")
    return folder


def write(made: SyntheticSession, folder: Path) -> Path:
    with BagWriter(folder) as bag:
        session_to_bag(made.recorded, bag, made.pictures, CAMERA)
    return folder


@pytest.fixture(scope="session")
def made() -> SyntheticSession:
    return session("made", np.random.default_rng(1))


@pytest.fixture(scope="session")
def made_bag(made: SyntheticSession, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its bag; read only."""
    return write(made, tmp_path_factory.mktemp("bags") / "made")
