"""The colour of an object is one hue, or none."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_perception.features.color import ColorConfig, object_color

CONFIG = ColorConfig()


def painted(hue: float, saturation: float, value: float, count: int = 100) -> np.ndarray:
    """(count, 3) uint8 pixels of one colour; hue [deg]."""
    rgb = colorsys.hsv_to_rgb(hue / 360, saturation, value)
    return np.tile(np.rint(np.array(rgb) * 255).astype(np.uint8), (count, 1))


def circular(a: float, b: float) -> float:
    """Smallest angle between two hues [deg]."""
    return abs((a - b + 180) % 360 - 180)


@given(st.floats(0, 359.9), st.floats(0.3, 1.0), st.floats(0.3, 0.95))
def test_plain_hue(hue: float, saturation: float, value: float) -> None:
    """A plain colour has its own hue, to the precision of 8 bits and of the circular angle."""
    color = object_color(painted(hue, saturation, value), CONFIG)
    assert color.hue is not None
    assert circular(color.hue, hue) < 4
    assert 0 <= color.hue < 360


@given(st.floats(0, 359.9), st.floats(0, 359.9))
def test_turning(hue: float, turn: float) -> None:
    """Turning every pixel's hue turns the mean: nothing special happens at red."""
    spread = [(-25, 30), (0, 40), (25, 30)]
    before = object_color(np.concatenate([painted(hue + d, 0.7, 0.7, n) for d, n in spread]), CONFIG)
    after = object_color(np.concatenate([painted(hue + turn + d, 0.7, 0.7, n) for d, n in spread]), CONFIG)
    assert before.hue is not None
    assert after.hue is not None
    assert circular(before.hue + turn, after.hue) < 4


@given(st.floats(0, 359.9), st.floats(0.0, 0.08), st.floats(0, 1))
def test_grey(hue: float, saturation: float, value: float) -> None:
    """An object with hardly any saturation has no hue."""
    color = object_color(painted(hue, saturation, value), CONFIG)
    if value > 0.3:  # darker, 8 bits alone make saturation
        assert color.hue is None
        assert color.name in ("white", "grey", "black")


@given(st.floats(0, 359.9))
def test_highlights_and_shadow(hue: float) -> None:
    """Highlights and shadow on a third of the object each do not change its hue."""
    shadow = np.random.default_rng(0).integers(0, 12, (100, 3)).astype(np.uint8)
    glare = np.full((100, 3), 255, dtype=np.uint8)
    color = object_color(np.concatenate([painted(hue, 0.6, 0.7), glare, shadow]), CONFIG)
    assert color.hue is not None
    assert circular(color.hue, hue) < 4


def test_opposite_colors() -> None:
    """Opposite colours in equal parts have no mean hue."""
    color = object_color(np.concatenate([painted(0, 0.8, 0.8), painted(180, 0.8, 0.8)]), CONFIG)
    assert color.hue is None
    assert color.name == "multicoloured"


@pytest.mark.parametrize(
    ("hue", "name"), [(0, "red"), (30, "orange"), (55, "yellow"), (120, "green"), (220, "blue"), (280, "purple")]
)
def test_names(hue: float, name: str) -> None:
    """The words are those people use."""
    assert object_color(painted(hue, 0.8, 0.8), CONFIG).name == name


def test_brown() -> None:
    """A dark orange is brown."""
    assert object_color(painted(25, 0.6, 0.4), CONFIG).name == "brown"
