"""Touching things come apart, hollow things stay in one piece, and what does not stand on the table is left out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.render import Box, Cylinder, Table, looking_at, render
from mbd_perception.synthetic.scoring import Score, score

SLANTED = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
RED, GREEN, BLUE, WHITE = (200, 40, 40), (40, 200, 40), (40, 40, 200), (220, 220, 220)


def scored(solids: list[Box | Cylinder], *, table: Table | None = None, seed: int = 0) -> Score:
    """How well a synthetic table is segmented without knowing the camera's pose."""
    view = render(solids, SLANTED, np.random.default_rng(seed), table=table, noise=2e-3)
    truth = np.where(view.labels > 1, view.labels, 0)
    return score(segment(view.frame, None, SegmentationConfig()).labels, truth, view.frame.depth > 0)


@settings(max_examples=10, deadline=None)
@given(st.floats(-0.5, 0.5), st.floats(0.04, 0.1), st.integers(0, 100))
def test_stacked(yaw: float, height: float, seed: int) -> None:
    """A box on a larger box of the same colour is an object of its own."""
    solids: list[Box | Cylinder] = [
        Box((0.6, 0.0, 0.0), (0.2, 0.25, height), WHITE, yaw),
        Box((0.6, 0.0, height), (0.1, 0.12, 0.07), WHITE, yaw + 0.2),
    ]
    result = scored(solids, seed=seed)
    assert result.found == 2
    assert result.weighted_overlap > 0.85


@settings(max_examples=10, deadline=None)
@given(st.floats(0.03, 0.08), st.floats(0.04, 0.12), st.integers(0, 100))
def test_hollow(radius: float, height: float, seed: int) -> None:
    """The rim, inside and outside of a cup or bowl are one object."""
    result = scored([Cylinder((0.6, 0.1, 0.0), radius, height, WHITE, wall=0.004)], seed=seed)
    assert result.found == 1
    assert result.weighted_overlap > 0.9


def test_ball_in_a_bowl_hides_it() -> None:
    """What stands in a bowl is not the bowl."""
    solids: list[Box | Cylinder] = [
        Cylinder((0.6, 0.0, 0.0), 0.12, 0.06, WHITE, wall=0.005),
        Box((0.6, 0.0, 0.005), (0.05, 0.05, 0.12), RED),
    ]
    assert scored(solids).found == 2


def test_thin() -> None:
    """Things 10 mm high are found."""
    solids: list[Box | Cylinder] = [
        Box((0.5, 0.2, 0.0), (0.02, 0.15, 0.010), RED),
        Box((0.6, -0.2, 0.0), (0.1, 0.05, 0.010), BLUE),
    ]
    assert scored(solids).found == 2


def test_half_covered() -> None:
    """A table of which things cover half is still the table, with floor in view, and at most one of 16 is missed."""
    solids: list[Box | Cylinder] = [
        Box(
            (0.45 + 0.17 * i, -0.3 + 0.2 * j, 0.0), (0.13, 0.16, 0.05 + 0.02 * ((i + j) % 3)), (40 + 60 * i, 90, 60 * j)
        )
        for i in range(4)
        for j in range(4)
    ]
    result = scored(solids, table=Table(x=(0.3, 1.1), y=(-0.42, 0.42), floor_z=-0.7))
    assert result.found >= 15
    assert result.weighted_overlap > 0.9


@pytest.mark.parametrize("wall", [1.205, 2.0, None])
def test_room(wall: float | None) -> None:
    """Floor, a wall at the table's edge or behind it, are neither table nor object."""
    solids: list[Box | Cylinder] = [
        Box((0.7, 0.2, 0.0), (0.08, 0.12, 0.1), RED),
        Cylinder((0.9, -0.2, 0.0), 0.05, 0.2, GREEN),
    ]
    result = scored(solids, table=Table(x=(0.2, 1.2), y=(-0.6, 0.6), floor_z=-0.74, wall_x=wall))
    assert result.found == 2
    assert result.false_objects == 0
    assert result.weighted_overlap > 0.9


def test_many() -> None:
    """Two hundred small things are found without trouble."""
    solids: list[Box | Cylinder] = [
        Box((0.45 + 0.045 * (i // 20), -0.42 + 0.044 * (i % 20), 0.0), (0.022, 0.022, 0.03), (40 * (i % 6), 99, 9))
        for i in range(200)
    ]
    result = scored(solids)
    assert abs(result.found - 200) <= 10
