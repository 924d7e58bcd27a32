"""What the node does when no parameter is given is what the algorithms do when nothing is given."""

from __future__ import annotations

from mbd_perception.features.measure import ObserveConfig
from mbd_perception.parameters import PERCEPTION
from mbd_perception.segmentation.components import JumpConfig
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmentation.table.plane import PlaneConfig


def test_same_defaults() -> None:
    """The node and the segment command find the same objects: their defaults agree."""
    default = PERCEPTION.values()
    assert default["min_height"] == SegmentationConfig().min_height
    assert default["min_area"] == SegmentationConfig().min_area
    assert default["depth_noise"] == PlaneConfig().noise == JumpConfig().noise
    assert default["base_frame"] == ObserveConfig.frame_id
