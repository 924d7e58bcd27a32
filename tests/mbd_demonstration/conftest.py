"""What tests of the demonstration node share."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from mbd_demonstration.synthetic import Demonstration, Move, Sensing, demonstrate, random_scene

# pytest's importlib mode does not put test folders on the path.
sys.path.insert(0, str(Path(__file__).parent))
from demonstration_session import BEGIN, Session


@pytest.fixture
def session(ros_domain: int, tmp_path: Path) -> Iterator[Session]:
    made = Session(ros_domain, tmp_path)
    yield made
    made.close()


@pytest.fixture(scope="module")
def shown() -> Demonstration:
    scene = random_scene(np.random.default_rng(3), 3)
    moves = (Move("s1", onto="s2"), Move("s3", onto="s1"))
    return demonstrate(scene, moves, Sensing(rate=10.0), np.random.default_rng(3), begin=BEGIN)
