"""Best and second-best assignments, and what each departure from the best costs, without enumeration.

Scores are (n, m) with n <= m; -inf forbids a pair. An assignment is (n,) columns, one for each row, all different.

From one optimal assignment everything else follows in O(n^3): let row a take the column of row b. Chains of such moves
that close are all the other assignments, and since the assignment is optimal no closed chain gains. So with the
all-pairs shortest chains (Floyd-Warshall on slacks made non-negative by potentials) the second best is the cheapest
closed chain, and what it costs to force a pair (i, j) is its own slack plus the cheapest chain from j's row back to i.
Columns nobody uses belong to one more, interchangeable, spare row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mbd_mapping.tables import Floats

Columns = NDArray[np.intp]


def best_assignment(score: Floats) -> Columns:
    """The columns of an assignment of greatest total score. Raises ValueError when every assignment is forbidden."""
    return linear_sum_assignment(score, maximize=True)[1]


def total(score: Floats, columns: Columns) -> float:
    """Sum of the scores of an assignment."""
    return float(score[np.arange(len(columns)), columns].sum())


def potentials(moves: Floats) -> Floats:
    """(..., N): cheapest chain of moves into each row, 0 at most, of ``moves`` (..., N, N) without a gaining cycle."""
    size = moves.shape[-1]
    each = moves.reshape(-1, size, size)
    reached = np.zeros(each.shape[:2])
    open_, now = np.arange(len(each)), each
    for _ in range(size):
        lower = np.minimum(reached[open_], (reached[open_, :, None] + now).min(axis=1))
        changed = (lower != reached[open_]).any(axis=1)
        if not changed.any():
            break
        reached[open_] = lower
        if not changed.all():
            # Those that have settled cost no more.
            open_, now = open_[changed], now[changed]
    return reached.reshape(moves.shape[:-1])


@dataclass(frozen=True)
class Detours:
    """What every departure from an optimal assignment costs.

    Attributes:
        columns: (n,) the optimal assignment.
        slack: (n, m) cost of giving row i column j, by potentials, >= 0; 0 on the assignment.
        release: (m,) cost of leaving column j unused, by potentials, >= 0; 0 for the unused ones.
        chain: (n + 1, n + 1) cheapest chain of moves from row a to row b; row n is the spare row.
        owner: (m,) row that owns column j, n for the spare row.
    """

    columns: Columns
    slack: Floats
    release: Floats
    chain: Floats
    owner: Columns

    @staticmethod
    def around(score: Floats, columns: Columns) -> Detours:
        """All detours around the optimal assignment ``columns`` of ``score`` (n, m)."""
        n, m = score.shape
        rows = np.arange(n)
        owner = np.full(m, n)
        owner[columns] = rows
        loss = score[rows, columns][:, None] - score
        move = np.full((n + 1, n + 1), np.inf)
        move[:n, :n] = loss[:, columns]
        if m > n:
            unused = np.flatnonzero(owner == n)
            move[:n, n] = loss[:, unused].min(axis=1)
            move[n, :n] = 0.0
        potential = potentials(move)
        # Rounding leaves -1e-16 where 0 is meant; clipped, ties cannot run away in the loop below.
        move = np.maximum(move + potential[:, None] - potential[None, :], 0.0)
        np.fill_diagonal(move, 0.0)
        slack = np.maximum(loss + potential[:n, None] - potential[owner][None, :], 0.0)
        release = np.maximum(potential[n] - potential[owner], 0.0)
        chain = move
        for k in range(n + 1):
            chain = np.minimum(chain, chain[:, k, None] + chain[None, k, :])
        return Detours(columns, slack, release, chain, owner)

    @property
    def forced(self) -> Floats:
        """(n, m): how much the best assignment with pair (i, j) scores below the best; inf if there is none."""
        return self.slack + self.chain[self.owner, : len(self.columns)].T

    @property
    def margin(self) -> float:
        """How much less the second-best assignment scores; inf when there is none."""
        loop = self.chain + self.chain.T
        np.fill_diagonal(loop, np.inf)
        return float(loop.min())

    def best_among_optimal(self, score: Floats, tolerance: float) -> Columns:
        """The best assignment for another ``score`` (n, m) among those optimal, within ``tolerance``, for this one.

        Those are the assignments of pairs without slack that leave no column unused that costs something to leave.
        """
        n, m = score.shape
        padded = np.zeros((m, m))
        padded[:n] = np.where(self.forced <= tolerance, score, -np.inf)
        left = self.release + self.chain[self.owner, n]
        padded[n:, (left > tolerance) & (self.owner < n)] = -np.inf
        return best_assignment(padded)[:n]
