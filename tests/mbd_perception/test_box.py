"""The upright box around points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mbd_perception.features.box import upright_box

rng = np.random.default_rng(0)
UNIT = rng.uniform(-0.5, 0.5, (4000, 2))
DISK = UNIT[np.hypot(*UNIT.T) < 0.5]


def turned(points: np.ndarray, yaw: float) -> np.ndarray:
    """Points turned about the origin, float32."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return (points @ np.array([[cos, sin], [-sin, cos]])).astype(np.float32)


@given(st.floats(-1.5, 1.5), st.floats(0.15, 0.3), st.floats(0.04, 0.08))
def test_turned_rectangle(yaw: float, depth: float, width: float) -> None:
    """A long rectangle is found at any angle, with its sides; the angle is at most an eighth of a turn."""
    assume(abs(abs(yaw) - math.pi / 4) > 0.05)
    box = upright_box(turned(UNIT * [depth, width], yaw), trim=0.0)
    assert -math.pi / 4 < box.yaw <= math.pi / 4
    assert sorted((box.depth, box.width)) == pytest.approx(sorted((depth, width)), rel=0.12)
    long_axis = box.yaw if box.depth > box.width else box.yaw + math.pi / 2
    assert abs((long_axis - yaw + math.pi / 2) % math.pi - math.pi / 2) < 0.12


@given(st.floats(-3, 3))
def test_round(yaw: float) -> None:
    """A round object is straight whichever way it is turned."""
    box = upright_box(turned(DISK * 0.1, yaw), trim=0.0)
    assert box.yaw == 0
    assert box.width == pytest.approx(0.1, rel=0.05)
    assert box.depth == pytest.approx(0.1, rel=0.05)


def test_stray_pixels() -> None:
    """A few stray points do not stretch the box."""
    stray = np.array([[0.3, 0.0], [-0.4, 0.2]])
    box = upright_box(np.concatenate([UNIT * 0.1, stray]).astype(np.float32))
    assert max(box.width, box.depth) < 0.11


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_points(count: int) -> None:
    """Even one point has a box with positive sides."""
    box = upright_box(np.zeros((count, 2), dtype=np.float32))
    assert box.width > 0
    assert box.depth > 0
