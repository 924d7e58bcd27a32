"""The colour of an object: one hue, or none when it is too grey to have one (paper sec. 4.1, feature c)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.quantile import median

HUE_NAMES = (
    (15.0, "red"),
    (42.0, "orange"),
    (70.0, "yellow"),
    (165.0, "green"),
    (190.0, "cyan"),
    (262.0, "blue"),
    (295.0, "purple"),
    (340.0, "pink"),
    (360.0, "red"),
)


@dataclass(frozen=True)
class ObjectColor:
    """What colour an object is.

    Attributes:
        hue: circular mean [deg, 0..360), None when too grey.
        saturation: mean HSV saturation, 0..1.
        name: a word for people.
        agreement: length of the mean hue vector, 0..1: 1 when all is of one hue.
    """

    hue: float | None
    saturation: float
    name: str
    agreement: float = 1.0


@dataclass(frozen=True)
class ColorConfig:
    """When an object has a hue.

    Attributes:
        min_saturation: below this mean saturation an object is grey: white balance alone shifts a white cup this far.
        min_agreement: length of the mean hue vector, 0..1, below which the colours of the object cancel out.
        dark, bright: share of full brightness below which a pixel is shadow, above which it may be a highlight.
    """

    min_saturation: float = 0.12
    min_agreement: float = 0.25
    dark: float = 0.08
    bright: float = 0.98


def object_color(rgb: NDArray[np.uint8], config: ColorConfig) -> ObjectColor:
    """The colour of the pixels of one object.

    Hue is a circular mean weighted by saturation. Highlights (clipped) have little saturation and shadows (nearly
    black) have a hue that is noise, so both are left out as long as other pixels remain.

    Args:
        rgb: (n, 3) uint8, n >= 1.
        config: thresholds.
    """
    red, green, blue = np.ascontiguousarray(rgb.T, dtype=np.float32)
    high = np.maximum(np.maximum(red, green), blue)
    low = np.minimum(np.minimum(red, green), blue)
    usable = (high >= 255 * config.dark) & (low < 255 * config.bright)
    if np.count_nonzero(usable) >= 0.2 * len(rgb):
        red, green, blue, high, low = (channel[usable] for channel in (red, green, blue, high, low))
    saturation = (high - low) / np.maximum(high, 1)
    # The hue angle of the hexagon is within 1.1 degrees of the angle in the alpha-beta plane, which needs no branches.
    alpha = red - 0.5 * (green + blue)
    beta = np.float32(0.8660254) * (green - blue)
    weight = saturation / np.maximum(np.sqrt(alpha * alpha + beta * beta), np.float32(1e-3))
    total = float(saturation.sum())
    x, y = float((alpha * weight).sum()), float((beta * weight).sum())
    mean_saturation = total / len(saturation)
    agreement = math.hypot(x, y) / total if total > 0 else 0.0
    brightness = median(high) / 255
    if mean_saturation < config.min_saturation or agreement < config.min_agreement or brightness < config.dark:
        grey = _grey_name(brightness, mean_saturation, config)
        return ObjectColor(hue=None, saturation=mean_saturation, name=grey, agreement=agreement)
    hue = math.degrees(math.atan2(y, x)) % 360.0
    hue = 0.0 if hue >= 360.0 else hue
    return ObjectColor(hue, mean_saturation, _hue_name(hue, mean_saturation, brightness), agreement)


def _grey_name(brightness: float, saturation: float, config: ColorConfig) -> str:
    """A word for an object without hue."""
    if saturation >= config.min_saturation and brightness >= config.dark:
        return "multicoloured"
    if brightness < 0.25:
        return "black"
    return "white" if brightness > 0.7 else "grey"


def _hue_name(hue: float, saturation: float, brightness: float) -> str:
    """A word for a hue [deg]; a dark or dull orange is what people call brown."""
    name = next(word for limit, word in HUE_NAMES if hue <= limit)
    if name == "orange" and (brightness < 0.6 or saturation < 0.45):
        return "brown"
    return name
