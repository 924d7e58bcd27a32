"""How much work an inference is, counted instead of timed, and that what is computed quickly is what it should be."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_mapping.assignment import assignment, permanent
from mbd_mapping.assignment.assignment import potentials
from mbd_mapping.assignment.blocks import blocks_of
from mbd_mapping.config import MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.similarity import HUE_SHIFT, Comparison
from mbd_mapping.synthetic import random_problem, random_table
from mbd_mapping.tables import ObjectTable
from mbd_mapping.teachers import in_turn
from mbd_mapping.teachers.shifts import ShiftSearch

ASSISTS = [(0, 1), (2, 3)]
Counts = Counter[str]


def scenes(size: int, variety: int = 0, seed: int = 0) -> Comparison:
    """Scenes of experiment 1, or of objects of which many are alike."""
    rng = np.random.default_rng([seed, size])
    config = MappingConfig(strategy="evidence")
    if variety:
        return Comparison.of(random_table(rng, size, "s", variety), random_table(rng, size, "t", variety), config)
    source, target = random_problem(rng, size)
    return Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), config)


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> Counts:
    """Counts assignments solved, searches for shifts, and matrices whose permanent is summed exactly."""
    found: Counts = Counter()

    def counted(name: str, function: Callable[..., Any], many: Callable[..., int]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            found[name] += many(*arguments)
            return function(*arguments, **named)

        return call

    solve = assignment.linear_sum_assignment
    monkeypatch.setattr(assignment, "linear_sum_assignment", counted("assignments", solve, lambda *_: 1))
    monkeypatch.setattr(permanent, "_forward", counted("permanents", permanent._forward, lambda w: w.shape[2]))
    monkeypatch.setattr(ShiftSearch, "solve", counted("searches", ShiftSearch.solve, lambda *_: 1))
    return found


def test_scenes_are_searched_for_shifts_once(counts: Counts) -> None:
    """What teachers may have in mind is found at the first call; an assist changes none of it."""
    comparison = scenes(7)
    infer_evidence(comparison, (), range(7))
    assert counts["searches"] > 0
    counts.clear()
    infer_evidence(comparison, ASSISTS, range(7))
    infer_evidence(comparison, ASSISTS[:1], range(7))
    assert counts["searches"] == 0


def test_nothing_told_sums_nothing_again(counts: Counts) -> None:
    """A second inference without an assist takes every sum over mappings from the first."""
    comparison = scenes(7)
    infer_evidence(comparison, (), range(7))
    assert counts["permanents"] > 0
    counts.clear()
    infer_evidence(comparison, (), range(7))
    assert counts["permanents"] == 0


@pytest.mark.parametrize("variety", [0, 4])
def test_assignments_solved_do_not_grow_with_the_scenes(counts: Counts, variety: int) -> None:
    """A hundred objects take about as many assignments as twenty, at the first call and after an assist."""
    solved = []
    for size in (20, 100):
        comparison = scenes(size, variety)
        for assists in ((), ASSISTS):
            counts.clear()
            infer_evidence(comparison, assists, range(size))
            solved.append(counts["assignments"])
    first, after, first_of_many, after_of_many = solved
    assert first_of_many <= 1.2 * first
    assert after_of_many <= after + 24
    assert after <= first / 3


@given(seed=st.integers(0, 2**32), size=st.integers(1, 6), density=st.sampled_from([0.1, 0.3, 0.6]))
def test_blocks_hold_the_pairs_of_perfect_matchings(seed: int, size: int, density: float) -> None:
    """A pair of weight is within a block exactly when some assignment of weight holds it, by enumeration."""
    rng = np.random.default_rng(seed)
    support = rng.random((size, size)) < density
    support[np.arange(size), rng.permutation(size)] |= rng.random() < 0.8
    held = np.zeros((size, size), dtype=bool)
    for columns in itertools.permutations(range(size)):
        if support[np.arange(size), columns].all():
            held[np.arange(size), columns] = True
    blocks = blocks_of(support)
    assert (blocks is None) == (not held.any())
    if blocks is not None:
        within = np.zeros((size, size), dtype=bool)
        for rows in (*blocks.single[:, None], *blocks.larger):
            within[np.ix_(rows, blocks.columns[rows])] = True
        assert (held == (support & within)).all()
        assert sorted([*blocks.single, *itertools.chain(*blocks.larger)]) == list(range(size))


@given(seed=st.integers(0, 2**32), size=st.integers(1, 7))
def test_potentials_of_many_are_those_of_each(seed: int, size: int) -> None:
    """Matrices that settle early, among others that do not, have the potentials they have alone."""
    rng = np.random.default_rng(seed)
    height = rng.normal(size=(4, size))
    moves = rng.random((4, size, size)) + height[:, :, None] - height[:, None, :]
    moves[:, np.arange(size), np.arange(size)] = 0.0
    moves[0] = np.abs(moves[0])
    together = potentials(moves)
    for own, alone in zip(moves, together, strict=True):
        assert potentials(own) == pytest.approx(alone)
        assert (alone[None, :] <= alone[:, None] + own + 1e-12).all()


@pytest.mark.parametrize("at_once", [1, 10**9])
def test_taking_in_turn_is_a_product_of_shares(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """Whatever is multiplied at once: for row after row the column's weight over that of all columns left."""
    monkeypatch.setattr(in_turn, "ONE_THREAD", at_once)
    rng = np.random.default_rng(3)
    weights = rng.random((5, 6, 6)) ** 4
    mappings = np.array([rng.permutation(6) for _ in range(7)])
    order = [2, 0, 1, 3, 5, 4]
    expected = np.zeros((5, 7))
    for h, c in itertools.product(range(5), range(7)):
        left = set(range(6))
        for row in order:
            column = int(mappings[c, row])
            expected[h, c] += np.log(weights[h, row, column] / weights[h, row, sorted(left)].sum())
            left.remove(column)
    found = in_turn.log_of_mappings(weights.transpose(1, 0, 2), mappings, order)
    assert found == pytest.approx(expected, abs=1e-9)


def test_shares_in_turn_are_probabilities() -> None:
    """Each column is taken once, each row goes somewhere, also where a confirmed assist leaves zeros."""
    weights = np.random.default_rng(5).random((2, 12, 12)) + 0.05
    weights[1, 4] = 0.0
    weights[1, 4, 7] = 1.0
    share = in_turn.shares_in_turn(weights)
    assert share.sum(axis=1) == pytest.approx(1.0, abs=1e-6)
    assert share[0].sum(axis=1) == pytest.approx(1.0, abs=1e-3)
    assert share[1, 4] == pytest.approx(np.eye(12)[7], abs=0.1)
    assert share[1, 4].argmax() == 7


def test_shifts_that_do_not_exist_are_searched_in_vain() -> None:
    """Where the hue differences of every mapping balance there is no hue shift, and an answer all the same."""
    none = (frozenset[str](),) * 2
    source = ObjectTable(("a", "b"), np.array([0.0, 180.0]), np.array([1.0, 1.0]), np.zeros((2, 4)), none, none)
    target = ObjectTable(("c", "d"), np.array([0.0, 0.0]), np.array([1.0, 1.0]), np.zeros((2, 4)), none, none)
    comparison = Comparison.of(source, target, MappingConfig(strategy="evidence"))
    weights = np.eye(7)[[HUE_SHIFT]]
    assert ShiftSearch(comparison).solve(weights, [(0.0, 1.0), (90.0, 1.0)], 4) == [[]]
    assert sorted(infer_evidence(comparison, (), range(2)).columns) == [0, 1]
