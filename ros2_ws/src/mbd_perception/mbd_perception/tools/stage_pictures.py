"""Every stage of a segmentation side by side, to see what it does and where it goes wrong."""

from __future__ import annotations

from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.features.measure import Observation
from mbd_perception.overlay import draw_overlay, draw_text, label_color
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.tools.stages import stages_of

Picture = NDArray[np.uint8]
Number = TypeVar("Number", np.uint8, np.int32)


def draw_stages(observation: Observation, config: SegmentationConfig | None = None) -> Picture:
    """(2 height, 3 width, 3) uint8 RGB: depth, height, surfaces; concavity, regions, objects.

    Args:
        observation: what was seen.
        config: what it was segmented with; the default when None.
    """
    config = config or SegmentationConfig()
    frame, found = observation.frame, observation.segmentation
    stages = stages_of(frame, found.plane, found.noise, config)
    heights, surfaces, parts = stages.heights, stages.surfaces, stages.parts
    seen = frame.depth > 0
    near, far = np.quantile(frame.depth[seen], (0.02, 0.98))
    panels = (
        ("depth", _scaled(frame.depth, near, far, seen)),
        ("height above the table, 0 to 15 cm", _scaled(heights, 0.0, 0.15, seen)),
        ("surfaces: apart at jumps in depth", _painted(surfaces, frame.color)),
        ("concavity: apart at creases", _doubled(_scaled(parts.bend, 0.0, 2.0, parts.bend >= 0), frame.color)),
        ("regions", _painted(_doubled(parts.regions.labels.astype(np.int32), frame.color), frame.color)),
        ("objects", draw_overlay(observation)),
    )
    titled = [_titled(picture, title) for title, picture in panels]
    return np.vstack([np.hstack(titled[:3]), np.hstack(titled[3:])])


def _scaled(values: NDArray[np.float32], low: float, high: float, valid: NDArray[np.bool_]) -> Picture:
    """Numbers as colours from blue (low) to red (high); black where not valid."""
    grey: Picture = np.clip((values - low) / max(high - low, 1e-6) * 255, 0, 255).astype(np.uint8)
    picture: Picture = cv2.applyColorMap(grey, cv2.COLORMAP_TURBO)[..., ::-1].copy()
    picture[~valid] = 0
    return picture


def _painted(labels: NDArray[np.integer], color: Picture) -> Picture:
    """Labels in distinct colours over a dimmed picture."""
    palette = np.array([(0, 0, 0)] + [label_color(i) for i in range(int(labels.max(initial=0)))], dtype=np.uint8)
    picture: Picture = np.where((labels > 0)[..., None], palette[labels] // 4 * 3 + color // 4, color // 3)
    return picture


def _doubled(half: NDArray[Number], like: Picture) -> NDArray[Number]:
    """A picture at half size at the full size of another."""
    return np.repeat(np.repeat(half, 2, axis=0), 2, axis=1)[: like.shape[0], : like.shape[1]]


def _titled(picture: NDArray[np.generic], title: str) -> Picture:
    """A copy of a picture with its title in the corner."""
    copy = np.ascontiguousarray(picture, dtype=np.uint8)
    draw_text(copy, title, (8, 22), 0.6)
    return copy
