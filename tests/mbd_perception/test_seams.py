"""Flush boxes of two plain colours come apart; print, stripes, lids, faces of another colour and shadows do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.casting import Solid
from mbd_perception.synthetic.paint import Paint, Pattern
from mbd_perception.synthetic.render import Box, Cylinder, SyntheticView, looking_at, render
from mbd_perception.synthetic.scoring import score

RED, GREEN, BLUE, YELLOW = (200, 40, 40), (40, 160, 60), (40, 60, 190), (220, 200, 50)
YAW = 0.7
ALONG = np.array([np.cos(YAW), np.sin(YAW)])


def seen(solids: list[Solid], seed: int = 0) -> SyntheticView:
    """The solids on a table, seen from above at a slant."""
    return render(solids, looking_at((-0.1, 0.05, 0.65), (0.65, 0.0, 0.05)), np.random.default_rng(seed), noise=2e-3)


def count(view: SyntheticView) -> int:
    """How many objects are found."""
    return segment(view.frame, None, SegmentationConfig()).count


def beside(height: float) -> list[Solid]:
    """Two boxes side by side, their fronts flush; the second of another height, or the same."""
    x, y = np.array([0.6, 0.0]) + 0.05 * ALONG
    u, v = np.array([0.6, 0.0]) - 0.05 * ALONG
    return [Box((x, y, 0.0), (0.1, 0.08, 0.09), RED, YAW), Box((u, v, 0.0), (0.1, 0.08, height), BLUE, YAW)]


def stacked() -> list[Solid]:
    """A box on one of the same outline."""
    return [Box((0.6, 0.0, z), (0.12, 0.08, 0.06), c, YAW) for z, c in ((0.0, GREEN), (0.06, YELLOW))]


@pytest.mark.parametrize("solids", [beside(0.09), beside(0.06), stacked()], ids=["beside", "lower", "stacked"])
@pytest.mark.parametrize("seed", range(3))
def test_flush(solids: list[Solid], seed: int) -> None:
    """Flush boxes of two colours are two objects, cut where they touch."""
    view = seen(solids, seed)
    found = segment(view.frame, None, SegmentationConfig())
    result = score(found.labels, np.where(view.labels > 1, view.labels, 0), view.frame.depth > 0)
    assert result.found == 2
    assert result.weighted_overlap > 0.9


@pytest.mark.parametrize("pattern", list(Pattern), ids=lambda p: p.name)
@pytest.mark.parametrize("colors", [(BLUE,), (BLUE, YELLOW)], ids=["two colours", "three colours"])
def test_print(pattern: Pattern, colors: tuple[tuple[int, int, int], ...]) -> None:
    """Whatever is printed on a box, a tin or a cup, it is one object."""
    solids: list[Solid] = [
        Box((0.55, 0.25, 0.0), (0.12, 0.08, 0.14), RED, YAW, Paint(pattern, colors, 3)),
        Cylinder((0.6, 0.0, 0.0), 0.04, 0.11, RED, paint=Paint(pattern, colors, 4)),
        Cylinder((0.6, -0.25, 0.0), 0.04, 0.1, RED, wall=0.004, paint=Paint(pattern, colors, 5)),
    ]
    assert count(seen(solids)) == 3


def test_lid() -> None:
    """A thin lid of another colour is part of its box."""
    lid: list[Solid] = [
        Box((0.6, 0.0, 0.0), (0.16, 0.12, 0.06), BLUE, YAW),
        Box((0.6, 0.0, 0.06), (0.16, 0.12, 0.01), RED, YAW),
    ]
    assert count(seen(lid)) == 1


@pytest.mark.parametrize("dark", [0.5, 0.7])
def test_shadow(dark: float) -> None:
    """A shadow or a highlight across a box does not cut it."""
    view = seen([Box((0.6, 0.0, 0.0), (0.12, 0.1, 0.12), RED, YAW)])
    color = view.frame.color.copy()
    columns = np.flatnonzero((view.labels > 1).any(axis=0))
    middle = int(columns.mean())
    color[:, middle:] = (color[:, middle:] * dark).astype(np.uint8)
    color[view.frame.color.shape[0] // 2 : view.frame.color.shape[0] // 2 + 8, middle - 8 : middle] = 255
    assert count(replace(view, frame=replace(view.frame, color=color))) == 1
