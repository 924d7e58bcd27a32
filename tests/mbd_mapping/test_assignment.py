"""What every departure from the best assignment costs, without trying them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.assignment.assignment import Detours, best_assignment, total
from mbd_mapping.assignment.ties import optimal_assignments

sizes = st.tuples(st.integers(1, 4), st.integers(0, 2))


def case(seed: int, size: tuple[int, int], levels: int) -> tuple[np.ndarray, dict[tuple[int, ...], float]]:
    """A score (n, m), n <= m, with ties when ``levels`` > 0, and every assignment with its total."""
    rng = np.random.default_rng(seed)
    n, m = size[0], sum(size)
    score = rng.integers(0, levels + 1, (n, m)) / levels if levels else rng.random((n, m))
    return score, {c: total(score, np.array(c)) for c in itertools.permutations(range(m), n)}


@given(seed=st.integers(0, 2**32), size=sizes, levels=st.integers(0, 3))
def test_forcing_a_pair_costs_what_enumeration_finds(seed: int, size: tuple[int, int], levels: int) -> None:
    """The best assignment with a pair in it scores exactly ``forced`` less than the best."""
    score, every = case(seed, size, levels)
    forced = Detours.around(score, best_assignment(score)).forced
    best = max(every.values())
    for row, column in np.ndindex(score.shape):
        with_pair = max(value for columns, value in every.items() if columns[row] == column)
        assert forced[row, column] == pytest.approx(best - with_pair, abs=1e-9)


@given(seed=st.integers(0, 2**32), size=sizes, levels=st.integers(0, 3))
def test_the_margin_is_that_of_the_second_best(seed: int, size: tuple[int, int], levels: int) -> None:
    """0 when several are best, inf when there is one assignment only."""
    score, every = case(seed, size, levels)
    values = sorted(every.values(), reverse=True)
    margin = Detours.around(score, best_assignment(score)).margin
    assert margin == pytest.approx(values[0] - values[1] if len(values) > 1 else np.inf, abs=1e-9)


@given(seed=st.integers(0, 2**32), size=sizes, levels=st.integers(0, 3))
def test_all_optimal_assignments_are_found_once(seed: int, size: tuple[int, int], levels: int) -> None:
    """Those of greatest total, each once, and no other."""
    score, every = case(seed, size, levels)
    best = max(every.values())
    found = [tuple(c.tolist()) for c in optimal_assignments(Detours.around(score, best_assignment(score)), 1e-9)]
    assert len(found) == len(set(found))
    assert set(found) == {columns for columns, value in every.items() if value >= best - 1e-9}


@given(seed=st.integers(0, 2**32), size=sizes)
def test_the_best_for_another_score_among_the_optimal(seed: int, size: tuple[int, int]) -> None:
    """Restricted to what is optimal for one score, the best for another is that of enumeration."""
    score, every = case(seed, size, 1)
    other, other_totals = case(seed + 1, size, 0)
    best = max(every.values())
    expected = max(other_totals[c] for c, value in every.items() if value >= best - 1e-9)
    chosen = Detours.around(score, best_assignment(score)).best_among_optimal(other, 1e-9)
    assert total(other, chosen) == pytest.approx(expected)
    assert every[tuple(chosen.tolist())] == pytest.approx(best)


def test_a_hundred_equal_objects_tie_without_end() -> None:
    """Of 100! ties the first thousand come at once, all different."""
    score = np.ones((100, 100))
    found = itertools.islice(optimal_assignments(Detours.around(score, best_assignment(score)), 1e-9), 1000)
    assert len({tuple(c.tolist()) for c in found}) == 1000
