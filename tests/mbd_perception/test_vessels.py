"""Open vessels from above are one thing each, whatever of their thin bottom is seen."""

from __future__ import annotations

import numpy as np
import pytest
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.synthetic.sensors import Sensor

ABOVE = looking_at((0.45, 0.0, 1.0), (0.7, 0.0, 0.0))


def count(*solids: Box | Cylinder) -> int:
    """How many objects are found from above."""
    view = render(list(solids), ABOVE, np.random.default_rng(4), sensor=Sensor(noise=2e-3))
    return segment(view.frame, None, SegmentationConfig()).count


@pytest.mark.parametrize(("radius", "height"), [(0.04, 0.09), (0.1, 0.03), (0.07, 0.06)])
def test_one_vessel(radius: float, height: float) -> None:
    """A cup, a dish and a bowl of straight sides."""
    assert count(Cylinder((0.7, 0.1, 0.0), radius, height, (200, 200, 190), wall=0.003)) == 1


def test_ring_of_boxes() -> None:
    """Two equal boxes beside each other are no vessel."""
    boxes = [Box((0.7, y, 0.0), (0.12, 0.03, 0.05), (200, 60, 40)) for y in (-0.04, 0.04)]
    assert count(*boxes) == 2
