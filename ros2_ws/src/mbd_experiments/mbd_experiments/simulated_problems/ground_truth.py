"""What a teacher who goes by a given feature set would do (paper sec. 5): the truth of a simulated problem.

The truth of a set g is the mapping of greatest V(m, g). Where g names a shift, its mean is that of the mapping itself,
as it is once every assist has been given (paper sec. 4.3.1). Such a mapping is found by turns: mapping from mean, mean
from mapping, started from the shift of every single pair.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from mbd_mapping.assignment.assignment import best_assignment, total
from mbd_mapping.similarity import HUE, HUE_SHIFT, NUM_FEATURES, SIZE, SIZE_SHIFT, Comparison
from mbd_mapping.tables import Floats

MAX_TURNS = 20
EXCLUDED = (frozenset({HUE, HUE_SHIFT}), frozenset({SIZE, SIZE_SHIFT}))
TRUTHS: tuple[tuple[int, ...], ...] = tuple(
    chosen
    for size in (1, 2)
    for chosen in itertools.combinations(range(NUM_FEATURES), size)
    if frozenset(chosen) not in EXCLUDED
)


def truth_score(comparison: Comparison, features: Sequence[int], columns: Sequence[int]) -> tuple[Floats, float]:
    """(mean similarity (n, m) of the set with the shifts of the mapping ``columns``, that mapping's total of it)."""
    layers, _ = comparison.at(list(enumerate(columns)))
    score: Floats = layers[list(features)].mean(axis=0)
    return score, total(score, np.asarray(columns))


def best_mapping(comparison: Comparison, features: Sequence[int]) -> tuple[Floats, tuple[int, ...]]:
    """The truth of a set: (score (n, m) it is best for, columns). Any one of several equals."""
    n, m = len(comparison.source), len(comparison.target)
    shifting = {HUE_SHIFT, SIZE_SHIFT} & set(features)
    starts = itertools.product(range(n), range(m)) if shifting else [(0, 0)]
    best: tuple[float, Floats, tuple[int, ...]] | None = None
    seen: set[tuple[int, ...]] = set()
    for start in starts:
        layers, _ = comparison.at([start])
        columns = tuple(int(c) for c in best_assignment(layers[list(features)].mean(axis=0)))
        for _ in range(MAX_TURNS):
            score, value = truth_score(comparison, features, columns)
            if best is None or value > best[0] + 1e-12:
                best = value, score, columns
            if columns in seen:
                break
            seen.add(columns)
            columns = tuple(int(c) for c in best_assignment(score))
    if best is None:
        return np.zeros((n, m)), ()
    return best[1], best[2]
