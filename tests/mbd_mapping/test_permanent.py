"""Sums over all assignments without going through them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.assignment.permanent import EXACT_SIZE, log_permanents, marginals


@given(seed=st.integers(0, 2**32), size=st.integers(1, 6), zeros=st.booleans())
def test_equals_the_sum_over_all_permutations(seed: int, size: int, zeros: bool) -> None:
    """Permanents and marginals equal enumeration, with zeros among the weights too."""
    rng = np.random.default_rng(seed)
    weights = rng.random((3, size, size)) ** 3
    if zeros:
        weights[rng.random(weights.shape) < 0.3] = 0.0
    total, share = np.zeros(3), np.zeros_like(weights)
    for columns in itertools.permutations(range(size)):
        product = weights[:, np.arange(size), columns].prod(axis=1)
        total += product
        share[:, np.arange(size), columns] += product[:, None]
    with np.errstate(divide="ignore"):
        assert log_permanents(weights) == pytest.approx(np.log(total), rel=1e-9, abs=1e-9)
    assert marginals(weights) == pytest.approx(share / np.where(total > 0, total, 1.0)[:, None, None], abs=1e-9)


def test_large_sizes_are_bounded_from_below() -> None:
    """Beyond the exact size the sum is exact for one mapping and at most 2^-N short for equal ones."""
    size = EXACT_SIZE + 9
    one = np.eye(size)[None]
    assert log_permanents(one)[0] == pytest.approx(0.0, abs=1e-6)
    exact = np.log(np.arange(1, size + 1)).sum()
    found = log_permanents(np.ones((1, size, size)))[0]
    assert exact - size * np.log(2) <= found <= exact


def test_large_sizes_do_not_overflow() -> None:
    """A hundred objects and tiny weights stay finite."""
    weights = np.full((2, 100, 100), 1e-5)
    assert np.isfinite(log_permanents(weights)).all()
    assert marginals(weights).sum(axis=2) == pytest.approx(1.0, abs=1e-3)
