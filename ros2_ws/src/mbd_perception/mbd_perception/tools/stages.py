"""The stages of a segmentation one by one, over the complete picture: for pictures of them and for training."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.segmentation.components import Labels
from mbd_perception.segmentation.holes import enclosed_patches, fill_holes
from mbd_perception.segmentation.segment import SegmentationConfig, TableTop, find_surfaces
from mbd_perception.segmentation.separation import Separation, separate
from mbd_perception.segmentation.table.extent import table_outline
from mbd_perception.segmentation.table.plane import Plane


@dataclass(frozen=True)
class Stages:
    """What one stage hands to the next.

    Attributes:
        heights: (height, width) float32 above the table [m].
        surfaces: (height, width) int32, 0 = none.
        parts: what they were separated into.
    """

    heights: FloatImage
    surfaces: Labels
    parts: Separation


def stages_of(frame: RgbdFrame, plane: Plane, noise: float, config: SegmentationConfig) -> Stages:
    """The stages after the table.

    Args:
        frame: what the camera saw.
        plane: the table, optical frame.
        noise: std of inverse depth on it [1/m].
        config: thresholds.
    """
    outline = table_outline(frame.depth, frame.camera, plane, noise, config.extent)
    heights = plane.height(frame.depth, frame.camera)
    surfaces, flat = find_surfaces(frame, heights, TableTop(plane, outline, noise), config)
    surfaces = fill_holes(surfaces, enclosed_patches(surfaces, frame.depth))
    parts = separate(frame, surfaces, heights, flat, noise=noise, jump=config.jump, config=config.separation)
    return Stages(heights, surfaces, parts)
