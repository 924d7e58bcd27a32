"""A synthetic session and its bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mbd_study.bag_writer import BagWriter
from mbd_study.conversions import session_to_bag
from mbd_study.synthetic import CAMERA, SyntheticSession, session


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
