"""How simulated teachers choose a mapping. None of it uses the code that infers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mbd_mapping.assignment.assignment import best_assignment
from mbd_mapping.similarity import HUE_SHIFT, NUM_FEATURES, SIZE_SHIFT
from mbd_mapping.strategy import UNMAPPED
from mbd_mapping.tables import Floats

from mbd_experiments.simulated_problems.ground_truth import TRUTHS, best_mapping
from mbd_experiments.teacher_families.lesson import Scenes

Choice = tuple[tuple[int, ...], Floats | None]
FIXED = tuple(k for k in range(NUM_FEATURES) if k not in (HUE_SHIFT, SIZE_SHIFT))


def by_set(scenes: Scenes, features: Sequence[int]) -> Choice:
    """The best mapping of a feature set, equally weighed, as in experiment 1."""
    score, columns = best_mapping(scenes.truth, features)
    return columns, score


def one_of(rng: np.random.Generator, sizes: Sequence[int]) -> tuple[int, ...]:
    """A random feature set of experiment 1 with one of these sizes."""
    sets = [s for s in TRUTHS if len(s) in sizes]
    return sets[int(rng.integers(len(sets)))]


def larger_set(rng: np.random.Generator) -> tuple[int, ...]:
    """Three or four features, not both shift and the feature it shifts."""
    while True:
        chosen = tuple(sorted(rng.choice(NUM_FEATURES, int(rng.integers(3, 5)), replace=False).tolist()))
        if not ({0, 1} <= set(chosen) or {2, 3} <= set(chosen)):
            return chosen


def best_of(score: Floats) -> tuple[int, ...]:
    """A best mapping of any score (n, m)."""
    n, m = score.shape
    if n <= m:
        return tuple(int(c) for c in best_assignment(score))
    columns = [UNMAPPED] * n
    for column, row in enumerate(best_assignment(score.T)):
        columns[int(row)] = column
    return tuple(columns)


def by_weights(rng: np.random.Generator, scenes: Scenes) -> Choice:
    """Weights from a flat Dirichlet over the features that need no shift."""
    weights = np.zeros(NUM_FEATURES)
    weights[list(FIXED)] = rng.dirichlet(np.ones(len(FIXED)))
    score = np.tensordot(weights, scenes.truth.fixed, axes=1)
    return best_of(score), score


def lexicographic(rng: np.random.Generator, scenes: Scenes) -> Choice:
    """One feature; where it leaves ties another decides."""
    first, second = (int(k) for k in rng.choice(np.array(FIXED), 2, replace=False))
    score = scenes.truth.fixed[first] + 1e-4 * scenes.truth.fixed[second]
    return best_of(score), score


def softly(rng: np.random.Generator, scenes: Scenes, noise: float) -> Choice:
    """One feature or two, but each object in turn is matched by softmax of similarity over ``noise``."""
    score, _ = best_mapping(scenes.truth, one_of(rng, (1, 2)))
    n, m = score.shape
    columns = [UNMAPPED] * n
    left = list(range(m))
    for row in rng.permutation(n):
        if not left:
            break
        odds = np.exp((score[row, left] - score[row, left].max()) / noise)
        columns[int(row)] = left.pop(int(rng.choice(len(left), p=odds / odds.sum())))
    return tuple(columns), None


def by_rank(source: Floats, target: Floats) -> Choice:
    """The first to the first and so on; the scenes are equally large. Equal values make no order of their own."""
    columns = np.empty(len(source), dtype=int)
    columns[np.argsort(source, kind="stable")] = np.argsort(target, kind="stable")
    return tuple(int(c) for c in columns), None


def anyhow(rng: np.random.Generator, scenes: Scenes) -> Choice:
    """By something that is not measured."""
    n, m = len(scenes.source), len(scenes.target)
    columns = [int(c) for c in rng.permutation(max(n, m))[:n]]
    return tuple(c if c < m else UNMAPPED for c in columns), None


def depth(table_positions: Floats | None) -> Floats:
    """(n,) distance from the robot [m]."""
    known = np.zeros((0, 2)) if table_positions is None else table_positions
    return known[:, 0]


def rightness(table_positions: Floats | None) -> Floats:
    """(n,) how far right [m]."""
    known = np.zeros((0, 2)) if table_positions is None else table_positions
    return -known[:, 1]
