"""The picture of a frame with its objects drawn in."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.features.measure import Observation

# Hues this far apart [deg] never repeat and neighbours differ: the golden angle.
GOLDEN_ANGLE = 137.508


def label_color(number: int) -> tuple[int, int, int]:
    """A distinct RGB colour for a label."""
    hsv = np.array([[[int(number * GOLDEN_ANGLE) % 360 // 2, 200, 255]]], dtype=np.uint8)
    red, green, blue = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0]
    return int(red), int(green), int(blue)


def draw_text(picture: NDArray[np.uint8], text: str, at: tuple[int, int], size: float) -> None:
    """White text with a black edge, readable on anything; in place."""
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        cv2.putText(picture, text, (at[0] + dx, at[1] + dy), cv2.FONT_HERSHEY_SIMPLEX, size, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, (255, 255, 255), 1, cv2.LINE_AA)


def draw_overlay(observation: Observation) -> NDArray[np.uint8]:
    """(height, width, 3) uint8 RGB: each object tinted and outlined, with its id, colour, class and size [cm]."""
    picture = observation.frame.color.copy()
    labels = observation.segmentation.labels
    for number, (label, obj) in enumerate(zip(observation.labels, observation.scene.objects, strict=True)):
        mask = (labels == label).view(np.uint8)
        x, y, width, height = cv2.boundingRect(mask)
        window = (slice(y, y + height), slice(x, x + width))
        inside = mask[window].view(bool)
        color = label_color(number)
        tinted = picture[window][inside] // 2 + np.array(color, dtype=np.uint8) // 2
        picture[window][inside] = tinted
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(picture, outlines, -1, color, 1)
        sides = " x ".join(f"{100 * side:.1f}" for side in obj.size)
        lines = (f"{obj.object_id} {obj.color_name} {obj.object_class}", sides)
        for row, text in enumerate(lines):
            at = (max(min(x, picture.shape[1] - 130), 2), max(y - 14 + 11 * row, 10))
            draw_text(picture, text, at, 0.42)
    return picture
