"""Makes the rig importable; pytest's importlib mode does not put test folders on the path."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy

sys.path.insert(0, str(Path(__file__).parent))
from perception_rig import Rig


@pytest.fixture
def context(ros_domain: int) -> Iterator[rclpy.Context]:
    """ROS in a domain of its own."""
    own = rclpy.Context()
    rclpy.init(context=own, domain_id=ros_domain)
    yield own
    own.try_shutdown()


@pytest.fixture
def rig(context: rclpy.Context) -> Iterator[Callable[..., Rig]]:
    """Makes rigs and ends them."""
    made: list[Rig] = []

    def make(messages: Callable[[], dict[str, object]], **parameters: object) -> Rig:
        made.append(Rig(context, messages, **parameters))
        return made[-1]

    yield make
    for one in made:
        one.close()
