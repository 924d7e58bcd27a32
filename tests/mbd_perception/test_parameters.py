"""What the node does when no parameter is given is what the algorithms do when nothing is given."""

from __future__ import annotations

from mbd_perception.features.measure import ObserveConfig
from mbd_perception.ros.parameters import PARAMETERS
from mbd_perception.segmentation.components import JumpConfig
from mbd_perception.segmentation.plane import PlaneConfig
from mbd_perception.segmentation.segment import SegmentationConfig


def test_same_defaults() -> None:
    """The node and the segment command find the same objects: their defaults agree."""
    default = {spec.name: spec.default for spec in PARAMETERS}
    assert default["min_height"] == SegmentationConfig().min_height
    assert default["min_area"] == SegmentationConfig().min_area
    assert default["depth_noise"] == PlaneConfig().noise == JumpConfig().noise
    assert default["base_frame"] == ObserveConfig.frame_id


def test_defaults_in_range() -> None:
    """Every default may also be given."""
    for spec in PARAMETERS:
        if spec.range is not None:
            assert isinstance(spec.default, int | float)
            assert spec.range[0] <= spec.default <= spec.range[1], spec.name
        if spec.choices:
            assert spec.default in spec.choices
