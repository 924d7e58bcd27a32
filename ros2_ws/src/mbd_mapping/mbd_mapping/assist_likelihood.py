"""What the assists reveal about a mapping when any of them may be wrong.

Each assist names a wrong target with a small probability, for itself; or, with a small probability, two of them were
given for each other, which an error each would make far too unlikely.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.assignment.permanent import TINY, log_permanents, marginals
from mbd_mapping.config import MappingConfig
from mbd_mapping.hypotheses import Hypotheses
from mbd_mapping.strategy import Pair
from mbd_mapping.tables import Floats


@dataclass(frozen=True)
class AssistLikelihood:
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
    def of(assists: Sequence[Pair], size: int, targets: int, config: MappingConfig) -> AssistLikelihood:
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
        return AssistLikelihood(likelihood, pairs, config.swap_error if len(pairs) > 1 else 0.0)

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

    def of_hypotheses(self, hypotheses: Hypotheses) -> Floats:
        """(H,): log of the sum, over the mappings of each hypothesis, of weight times probability of the claims."""
        out = np.empty(len(hypotheses.weights))
        one, several = hypotheses.unique, ~hypotheses.unique
        with np.errstate(divide="ignore"):
            out[one] = np.log(hypotheses.copies * self.of_mappings(hypotheses.columns[one]))
        out[several] = self._parts(hypotheses.weights[several])[0]
        return out

    def marginals(self, hypotheses: Hypotheses) -> Floats:
        """(H, N, N): probability that row i goes to column j, given each hypothesis and the claims."""
        out = np.zeros_like(hypotheses.weights)
        one, several = np.flatnonzero(hypotheses.unique), ~hypotheses.unique
        out[one[:, None], np.arange(out.shape[1]), hypotheses.columns[one]] = 1.0
        weights = hypotheses.weights[several]
        each = marginals(weights * self.likelihood)
        if self.swap:
            log_sum, log_swapped, known = self._parts(weights)
            share = np.exp(log_swapped - log_sum)[:, None, None]
            swapped = np.zeros_like(each)
            rows, free_rows, free_columns = self._split(len(self.likelihood))
            swapped[:, free_rows[:, None], free_columns] = marginals(weights[:, free_rows[:, None], free_columns])
            chosen = known / np.maximum(known.sum(axis=1, keepdims=True), TINY)
            for place, columns in enumerate(self.exchanged()):
                swapped[:, rows, columns] += chosen[:, place, None]
            each = (1.0 - share) * each + share * swapped
        out[several] = each
        return out

    def _split(self, size: int) -> tuple[Columns, Columns, Columns]:
        """(rows with a claim, rows without, columns nobody claimed)."""
        rows, columns = (np.array(side, dtype=np.intp) for side in zip(*self.pairs, strict=True))
        free_rows, free_columns = np.ones(size, dtype=bool), np.ones(size, dtype=bool)
        free_rows[rows] = free_columns[columns] = False
        return rows, np.flatnonzero(free_rows), np.flatnonzero(free_columns)

    def _parts(self, weights: Floats) -> tuple[Floats, Floats, Floats]:
        """(log sum (H,), log of its part in which two claims were exchanged (H,), weight of each exchange (H, K))."""
        each = log_permanents(weights * self.likelihood)
        if not self.swap:
            return each, np.full(len(weights), -np.inf), np.zeros((len(weights), 0))
        rows, free_rows, free_columns = self._split(weights.shape[1])
        known: Floats = weights[:, rows[None, :], self.exchanged()].prod(axis=2)
        with np.errstate(divide="ignore"):
            swapped = np.log(self.swap * known.mean(axis=1))
        possible = np.flatnonzero(known.any(axis=1))
        swapped[possible] += log_permanents(weights[possible[:, None, None], free_rows[:, None], free_columns])
        return np.logaddexp(np.log1p(-self.swap) + each, swapped), swapped, known
