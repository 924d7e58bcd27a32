"""Colours with a meaning, the same on both pages and in the pictures of a session, and text made safe for a page."""

from __future__ import annotations

import colorsys
from html import escape

from mbd_model.colors import PREDICTED
from mbd_model.objects import SceneObject

INFERRED = PREDICTED
GOOD, BAD, MUTED = "#2b8a57", "#c92f3c", "#8b9096"
GREY = "#9aa0a6"  # for objects without a hue


def color_of(thing: SceneObject) -> str:
    """A CSS colour like the object's own."""
    if thing.hue is None:
        return GREY
    red, green, blue = colorsys.hsv_to_rgb(thing.hue / 360.0, 0.7, 0.85)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"


def safe(text: object) -> str:
    """Text for HTML and SVG, in elements and in quoted attributes."""
    return escape(str(text), quote=True)
