"""The shortcuts that segmentation counts with give what numpy gives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mbd_perception.quantile import interpolated_quantile, median
from mbd_perception.segmentation.components import renumbered
from mbd_perception.segmentation.regions import Regions

NUMBERS = arrays(np.float64, st.integers(1, 40), elements=st.floats(-1e3, 1e3))


@given(NUMBERS, st.floats(0.0, 1.0))
def test_quantiles_are_those_of_numpy(values: np.ndarray, share: float) -> None:
    """The median is exactly numpy's, a quantile up to rounding."""
    assert median(values) == np.median(values)
    assert interpolated_quantile(values, share) == pytest.approx(np.quantile(values, share), abs=1e-9)


@given(arrays(np.int32, (5, 7), elements=st.integers(0, 299)), st.sampled_from((300, 5000)))
def test_renumbering_looks_every_label_up(labels: np.ndarray, last: int) -> None:
    """Label k becomes the k-th number, whether the numbers fit into a table of bytes or not."""
    few = labels % 250
    for picture, count in ((few, 250), (labels, last)):
        numbers = np.arange(count)[::-1].copy()
        assert np.array_equal(renumbered(picture, numbers), numbers[picture])


@given(arrays(np.uint16, (6, 9), elements=st.integers(0, 4)))
def test_sums_and_quantiles_of_a_region_are_those_of_its_pixels(labels: np.ndarray) -> None:
    """Regions without a pixel have 0; the others what numpy says of the pixels that carry their number."""
    samples = Regions(labels, 4, np.arange(5, dtype=np.int32)).samples
    value = np.sin(np.arange(labels.size, dtype=np.float64))[samples.pixels]
    sums, highest = samples.sums(value), samples.quantiles(value, 1.0)
    for number in range(1, 5):
        own = np.sin(np.flatnonzero(labels.ravel() == number).astype(np.float64))
        assert samples.sizes[number] == len(own)
        assert sums[number] == pytest.approx(own.sum())
        assert highest[number] == (own.max() if len(own) else 0.0)
