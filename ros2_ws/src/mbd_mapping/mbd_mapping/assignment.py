"""Best, second-best and k-best assignments without enumeration.

Scores are (n, m) with n <= m; -inf forbids a pair. An assignment is (n,) columns, one for each row, all different.

From one optimal assignment everything else follows in O(n^3): let row a take the column of row b. Chains of such moves
that close are all the other assignments, and since the assignment is optimal no closed chain gains. So with the
all-pairs shortest chains (Floyd-Warshall on slacks made non-negative by potentials) the second best is the cheapest
closed chain, and what it costs to force a pair (i, j) is its own slack plus the cheapest chain from j's row back to i.
Columns nobody uses belong to one more, interchangeable, spare row.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator
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
    reached = np.zeros(moves.shape[:-1])
    for _ in range(moves.shape[-1]):
        lower = np.minimum(reached, (reached[..., :, None] + moves).min(axis=-2))
        if np.array_equal(lower, reached):
            break
        reached = lower
    return reached


@dataclass(frozen=True)
class Detours:
    """What every departure from an optimal assignment costs.

    Attributes:
        columns: (n,) the optimal assignment.
        slack: (n, m) cost of giving row i column j, by potentials, >= 0; 0 on the assignment.
        release: (m,) cost of leaving column j unused, by potentials, >= 0; 0 for the unused ones.
        chain: (n + 1, n + 1) cheapest chain of moves from row a to row b; row n is the spare row.
        via: (n + 1, n + 1) a row between on that chain, -1 where the move is direct.
        owner: (m,) row that owns column j, n for the spare row.
        spare_column: (n,) best unused column of each row, -1 when there is none.
    """

    columns: Columns
    slack: Floats
    release: Floats
    chain: Floats
    via: NDArray[np.intp]
    owner: Columns
    spare_column: Columns

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
        spare_column = np.full(n, -1)
        if m > n:
            unused = np.flatnonzero(owner == n)
            spare_column = unused[np.argmin(loss[:, unused], axis=1)]
            move[:n, n] = loss[rows, spare_column]
            move[n, :n] = 0.0
        potential = potentials(move)
        # Rounding leaves -1e-16 where 0 is meant; clipped, ties cannot run away in the loop below.
        move = np.maximum(move + potential[:, None] - potential[None, :], 0.0)
        np.fill_diagonal(move, 0.0)
        slack = np.maximum(loss + potential[:n, None] - potential[owner][None, :], 0.0)
        release = np.maximum(potential[n] - potential[owner], 0.0)
        chain, via = move, np.full((n + 1, n + 1), -1)
        for k in range(n + 1):
            through = chain[:, k, None] + chain[None, k, :]
            shorter = through < chain
            if shorter.any():
                chain = np.where(shorter, through, chain)
                via[shorter] = k
        return Detours(columns, slack, release, chain, via, owner, spare_column)

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

    def second_best(self) -> tuple[Columns, float] | None:
        """The best assignment other than ``columns`` and how much less it scores; None when there is no other."""
        n = len(self.columns)
        if n == 0:
            return None
        loop = self.chain + self.chain.T
        np.fill_diagonal(loop, np.inf)
        a, b = np.unravel_index(int(np.argmin(loop)), loop.shape)
        if not np.isfinite(loop[a, b]):
            return None
        cycle = _simple_cycle([*self._walk(int(a), int(b)), *self._walk(int(b), int(a))])
        columns = self.columns.copy()
        for row, taken in zip(cycle, [*cycle[1:], cycle[0]], strict=True):
            if row < n:
                columns[row] = self.spare_column[row] if taken == n else self.columns[taken]
        return columns, float(loop[a, b])

    def _walk(self, a: int, b: int) -> list[int]:
        """Rows of the chain from a to b, without b."""
        middle = int(self.via[a, b])
        return [a] if middle < 0 else [*self._walk(a, middle), *self._walk(middle, b)]


def _simple_cycle(walk: list[int]) -> list[int]:
    """A simple cycle of at least two rows out of a closed walk: free moves may make the walk visit a row twice."""
    seen: dict[int, int] = {}
    for place, row in enumerate(walk):
        if row in seen and place - seen[row] > 1:
            return walk[seen[row] : place]
        seen[row] = place
    return walk


def ranked_assignments(score: Floats) -> Iterator[tuple[Columns, float]]:
    """Every assignment, best first, as (columns, total): Chegireddy and Hamacher's splitting by the second best.

    Each costs O(n^3): a space of assignments with its best M and second best N is split, by a pair of M that N lacks,
    into those with the pair (best: M) and those without (best: N).
    """
    counter = itertools.count()
    heap: list[tuple[float, int, Columns, Columns, Floats, tuple[int, ...]]] = []

    def push(space: Floats, fixed: tuple[int, ...], best: Columns, best_total: float) -> None:
        free = np.setdiff1d(np.arange(len(best)), np.array(fixed, dtype=np.intp))
        open_columns = np.setdiff1d(np.arange(space.shape[1]), best[list(fixed)])
        place = np.full(space.shape[1], -1)
        place[open_columns] = np.arange(len(open_columns))
        found = Detours.around(space[np.ix_(free, open_columns)], place[best[free]]).second_best()
        if found is None:
            return
        second = best.copy()
        second[free] = open_columns[found[0]]
        heapq.heappush(heap, (-(best_total - found[1]), next(counter), best, second, space, fixed))

    best = best_assignment(score)
    best_total = total(score, best)
    yield best, best_total
    push(score, (), best, best_total)
    while heap:
        negative, _, first, second, space, fixed = heapq.heappop(heap)
        yield second, -negative
        row = int(np.flatnonzero(first != second)[0])
        push(space, (*fixed, row), first, total(score, first))
        without = space.copy()
        without[row, first[row]] = -np.inf
        push(without, fixed, second, -negative)
