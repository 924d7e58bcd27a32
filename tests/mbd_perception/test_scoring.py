"""The score of a segmentation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mbd_perception.synthetic.scoring import score

pictures = hnp.arrays(np.int32, (6, 8), elements=st.integers(0, 4))
EVERYWHERE = np.ones((6, 8), dtype=bool)


@given(pictures)
def test_perfect(truth: np.ndarray) -> None:
    """The truth itself scores 1, under whatever numbers."""
    for labels in (truth, np.where(truth > 0, 9 - truth, 0)):
        result = score(labels, truth, EVERYWHERE)
        assert result.weighted_overlap == pytest.approx(1.0)
        assert result.over_segmentation == pytest.approx(0.0)
        assert result.under_segmentation == pytest.approx(0.0)
        assert result.right_count
        assert result.false_objects == 0 or not truth.any()


@given(pictures, pictures)
def test_bounds(labels: np.ndarray, truth: np.ndarray) -> None:
    """Overlap and over-segmentation are shares."""
    result = score(labels, truth, EVERYWHERE)
    assert 0 <= result.weighted_overlap <= 1
    assert 0 <= result.over_segmentation <= 1
    assert result.under_segmentation >= 0


def test_halves() -> None:
    """An object cut in two halves overlaps by a half; two objects made one are under-segmented."""
    complete = np.ones((6, 8), dtype=np.int32)
    halves = complete.copy()
    halves[:3] = 2
    assert score(halves, complete, EVERYWHERE).weighted_overlap == pytest.approx(0.5)
    assert score(halves, complete, EVERYWHERE).over_segmentation == pytest.approx(0.5)
    assert score(complete, halves, EVERYWHERE).under_segmentation == pytest.approx(1.0)


def test_false_object() -> None:
    """A segment where nothing is counts as false; pixels without depth do not count at all."""
    truth = np.zeros((6, 8), dtype=np.int32)
    truth[:2] = 1
    labels = truth.copy()
    labels[4:] = 2
    assert score(labels, truth, EVERYWHERE).false_objects == 1
    seen = EVERYWHERE.copy()
    seen[4:] = False
    assert score(labels, truth, seen).false_objects == 0
