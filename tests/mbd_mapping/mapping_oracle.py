"""The paper's rule by enumeration of every mapping and every feature set: what the product must equal. Tests only."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_mapping.feature_sets import Bools
from mbd_mapping.tables import Floats

TOLERANCE = 1e-9


@dataclass(frozen=True)
class Enumerated:
    """What enumeration finds.

    Attributes:
        value: the best V / (n |f|).
        tied: every mapping of that value, columns by row, -1 for unmapped.
        alpha, beta: row of ``members``; beta is None when no set maps otherwise.
        beta_value: value of beta.
        confidence: eq. 7, where no set maps otherwise shared among the tied mappings.
    """

    value: float
    tied: frozenset[tuple[int, ...]]
    alpha: int
    beta: int | None
    beta_value: float
    confidence: float


def all_mappings(n: int, m: int, pairs: Sequence[tuple[int, int]]) -> list[tuple[int, ...]]:
    """Every injective mapping of as many objects as possible that holds the pairs."""
    if n <= m:
        found = itertools.permutations(range(m), n)
    else:
        found = (
            tuple(rows.index(r) if r in rows else -1 for r in range(n)) for rows in itertools.permutations(range(n), m)
        )
    return [columns for columns in found if all(columns[r] == c for r, c in pairs)]


def enumerate_all(layers: Floats, members: Bools, pairs: Sequence[tuple[int, int]]) -> Enumerated:
    """Algorithm 1 and eq. 3-7 as they are written, over n! mappings."""
    _, n, m = layers.shape
    mappings = all_mappings(n, m, pairs)
    table = np.array(mappings)
    rows = np.arange(n)
    picked = np.where(table[None] >= 0, layers[:, rows[None, :], table], 0.0).sum(axis=2)
    values = (members @ picked) / (members.sum(axis=1)[:, None] * min(n, m))
    best_of_set = values.max(axis=1)
    best = float(best_of_set.max())
    tied = frozenset(mappings[k] for k in np.flatnonzero(values.max(axis=0) >= best - TOLERANCE))
    alpha = int(np.flatnonzero(best_of_set >= best - TOLERANCE)[0])
    best_mappings = values >= best_of_set[:, None] - TOLERANCE
    other = [f for f in range(len(members)) if f != alpha and not (best_mappings[f] & best_mappings[alpha]).any()]
    beta = max(other, key=lambda f: best_of_set[f], default=None)
    if beta is None:
        # The paper would say the whole value; of several equals it is a guess, and is not called sure.
        return Enumerated(best, tied, alpha, None, 0.0, float(best_of_set[alpha]) / len(tied))
    beta_value = float(best_of_set[beta])
    return Enumerated(best, tied, alpha, beta, beta_value, float(best_of_set[alpha]) - beta_value)
