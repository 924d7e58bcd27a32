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


def test_a_large_matrix_falls_into_blocks() -> None:
    """Beyond the exact size the sum is exact where what can be exchanged is: blocks of equal objects, in any order."""
    rng = np.random.default_rng(1)
    sizes = (1, 2, 4, 6, 7)
    whole = np.zeros((20, 20))
    start, exact = 0, 0.0
    for size in sizes:
        block = rng.uniform(0.1, 1.0, (size, size))
        whole[start : start + size, start : start + size] = block
        exact += float(log_permanents(block[None])[0])
        start += size
    assert start > EXACT_SIZE
    # A pair above the blocks closes no walk: it is in no assignment.
    whole[0, 19] = 1.0
    shuffled = whole[rng.permutation(20)][:, rng.permutation(20)]
    assert log_permanents(shuffled[None])[0] == pytest.approx(exact)
    assert marginals(shuffled[None]).sum(axis=2) == pytest.approx(1.0)


def test_a_large_matrix_without_an_assignment_sums_to_nothing() -> None:
    """Two rows that can only have the same column leave no assignment."""
    weights = np.ones((1, 14, 14))
    weights[0, :2, 1:] = 0.0
    assert log_permanents(weights)[0] == -np.inf


@pytest.mark.parametrize("size", [EXACT_SIZE + 1, 20, 40])
def test_a_large_block_of_equals_is_nearly_exact(size: int) -> None:
    """Where no structure is left the sum is that of equal pairs to one percent."""
    assert log_permanents(np.ones((1, size, size)))[0] == pytest.approx(np.log(np.arange(1, size + 1)).sum(), abs=0.01)


def test_large_sizes_do_not_overflow() -> None:
    """A hundred objects and tiny weights stay finite."""
    weights = np.full((2, 100, 100), 1e-5)
    assert np.isfinite(log_permanents(weights)).all()
    assert marginals(weights).sum(axis=2) == pytest.approx(1.0, abs=1e-3)
