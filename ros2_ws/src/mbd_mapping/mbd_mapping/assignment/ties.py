"""All optimal assignments, one after the other, from one of them (Fukuda and Matsui's splitting).

Two optimal assignments differ by closed chains of moves that cost nothing. So: find such a chain, take it, and split
what is left by one of the pairs that changed: the assignments that keep it, of which the old one is known, and those
without it, of which the new one is. Each costs one search for a closed chain, over bit sets.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbd_mapping.assignment.assignment import Columns, Detours
from mbd_mapping.assignment.blocks import bit_sets


def optimal_assignments(detours: Detours, tolerance: float) -> Iterator[Columns]:
    """Every assignment made of pairs that are optimal within ``tolerance``, the given one first."""
    n = len(detours.columns)
    yield detours.columns
    allowed = detours.forced <= tolerance
    if allowed.sum() == n:
        return
    left = detours.release + detours.chain[detours.owner, n]
    may_leave = (left <= tolerance) | (detours.owner == n)
    pairs = bit_sets(allowed)
    stack: list[tuple[list[int], list[int]]] = [([int(c) for c in detours.columns], pairs)]
    while stack:
        columns, pairs = stack.pop()
        other = _another(columns, pairs, may_leave.tolist())
        if other is None:
            continue
        yield np.array(other, dtype=np.intp)
        row = next(r for r in range(n) if columns[r] != other[r])
        bit = 1 << columns[row]
        keeping = [bit if r == row else p & ~bit for r, p in enumerate(pairs)]
        without = [p & ~bit if r == row else p for r, p in enumerate(pairs)]
        stack += [(columns, keeping), (other, without)]


def _another(columns: list[int], pairs: list[int], may_leave: Sequence[bool]) -> list[int] | None:
    """Another assignment of allowed pairs, or None: the first closed chain a depth-first search meets.

    Node r < n is row r, which may take any column of ``pairs[r]``; node n is nobody, who holds the unused columns.
    """
    n = len(columns)
    owner = {column: row for row, column in enumerate(columns)}

    def moves(node: int) -> Iterator[tuple[int, int]]:
        """(column taken, who held it) of every move of a node."""
        if node == n:
            for row, column in enumerate(columns):
                if may_leave[column]:
                    yield column, row
            return
        free = pairs[node] & ~(1 << columns[node])
        while free:
            low = free & -free
            free ^= low
            column = low.bit_length() - 1
            yield column, owner.get(column, n)

    new, open_, closed = 0, 1, 2
    state = [new] * (n + 1)
    for start in range(n):
        if state[start] != new:
            continue
        path, taken, waiting = [start], [-1], [moves(start)]
        state[start] = open_
        while path:
            column, following = next(waiting[-1], (-1, -1))
            if following < 0:
                state[path.pop()] = closed
                taken.pop()
                waiting.pop()
            elif state[following] == open_:
                first = path.index(following)
                out = list(columns)
                for row, got in zip(path[first:], [*taken[first + 1 :], column], strict=True):
                    if row < n:
                        out[row] = got
                return out
            elif state[following] == new:
                state[following] = open_
                path.append(following)
                taken.append(column)
                waiting.append(moves(following))
    return None
