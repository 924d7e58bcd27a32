"""What the assists say about a mapping when any of them may be wrong.

Each assist names a wrong target with a small probability, for itself; or, with a small probability, two of them were
given for each other, which an error each would make far too unlikely.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbd_mapping.assignment import Columns
from mbd_mapping.config import MappingConfig
from mbd_mapping.permanent import log_permanents
from mbd_mapping.strategy import Pair
from mbd_mapping.tables import Floats


@dataclass(frozen=True)
class Claims:
    """The assists as evidence: repeating one adds nothing.

    Attributes:
        likelihood: (N, N) probability of all claims about row i if its column is j, each wrong for itself.
        pairs: the claims, when no two contradict each other; else ().
        swap: probability that two of ``pairs`` were given for each other; 0 when there are fewer than two.
    """

    likelihood: Floats
    pairs: tuple[Pair, ...]
    swap: float

    @staticmethod
    def of(assists: Sequence[Pair], size: int, targets: int, config: MappingConfig) -> Claims:
        """Claims over N = ``size`` rows and columns, of which the first ``targets`` columns are objects."""
        distinct = tuple(dict.fromkeys(assists))
        likelihood = np.ones((size, size))
        for row, column in distinct:
            factor = np.full(size, config.assist_error / max(1, targets - 1))
            factor[column] = 1.0 - config.assist_error
            likelihood[row] *= factor
        rows, columns = {r for r, _ in distinct}, {c for _, c in distinct}
        consistent = len(rows) == len(columns) == len(distinct)
        pairs = distinct if consistent else ()
        return Claims(likelihood, pairs, config.swap_error if len(pairs) > 1 else 0.0)

    def exchanged(self) -> Columns:
        """(k (k - 1) / 2, k): columns of the k claims with each two of them exchanged."""
        columns = np.array([c for _, c in self.pairs], dtype=np.intp)
        pairs = list(itertools.combinations(range(len(columns)), 2))
        out = np.tile(columns, (len(pairs), 1))
        for place, (a, b) in enumerate(pairs):
            out[place, [a, b]] = columns[[b, a]]
        return out

    def of_mappings(self, mappings: Columns) -> Floats:
        """(C,): probability of the claims given each mapping (C, N)."""
        each: Floats = self.likelihood[np.arange(mappings.shape[1]), mappings].prod(axis=1)
        if not self.swap:
            return each
        claimed = mappings[:, [r for r, _ in self.pairs]]
        hit: Floats = (claimed[:, None, :] == self.exchanged()[None, :, :]).all(axis=2).mean(axis=1)
        return (1.0 - self.swap) * each + self.swap * hit

    def of_hypotheses(self, weights: Floats) -> Floats:
        """(H,): log of the sum, over all mappings, of weight times probability of the claims; ``weights`` (H, N, N)."""
        each = log_permanents(weights * self.likelihood)
        if not self.swap:
            return each
        rows = np.array([r for r, _ in self.pairs])
        size = weights.shape[1]
        free_rows = np.setdiff1d(np.arange(size), rows)
        free_columns = np.setdiff1d(np.arange(size), [c for _, c in self.pairs])
        known = weights[:, rows[None, :], self.exchanged()].prod(axis=2).mean(axis=1)
        with np.errstate(divide="ignore"):
            swapped = np.log(self.swap * known)
        possible = np.flatnonzero(known > 0)
        rest = log_permanents(weights[np.ix_(possible, free_rows, free_columns)])
        swapped[possible] += rest
        out: Floats = np.logaddexp(np.log1p(-self.swap) + each, swapped)
        return out
