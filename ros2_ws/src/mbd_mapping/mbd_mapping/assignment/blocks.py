"""The blocks a matrix of weights falls into: pairs of two blocks are never in one assignment of weight together.

With one perfect matching of the pairs of weight, let row a point to the row that owns column b wherever (a, b) has
weight. A pair is in some perfect matching exactly when its two rows lie on a closed walk: the strong components of that
graph are the blocks, and the permanent is the product of theirs (Dulmage and Mendelsohn 1958). They are found by two
depth-first searches (Kosaraju) over bit sets, which visit each row once: matrices are small, and there are many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Rows = NDArray[np.intp]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class MatrixBlocks:
    """The blocks of one matrix.

    Attributes:
        columns: (N,) a perfect matching: row i has weight with column ``columns[i]``, which is of the same block.
        single: (S,) the rows that are a block alone.
        larger: the rows of each block of two or more.
    """

    columns: Rows
    single: Rows
    larger: tuple[Rows, ...]


def blocks_of(support: Bools) -> MatrixBlocks | None:
    """The blocks of a matrix that has weight where ``support`` (N, N); None when no assignment has weight."""
    size = len(support)
    every = np.arange(size)
    if size > 1 and support.all():
        return MatrixBlocks(every, every[:0], (every,))
    columns: Rows = linear_sum_assignment(support, maximize=True)[1]
    if not support[every, columns].all():
        return None
    onward = support[:, columns]
    if np.count_nonzero(onward) == size:
        return MatrixBlocks(columns, every, ())
    label = _strong_components(onward)
    sizes = np.bincount(label)
    order = np.argsort(label, kind="stable")
    ends = np.cumsum(sizes)
    larger = tuple(order[ends[k] - sizes[k] : ends[k]] for k in np.flatnonzero(sizes > 1))
    return MatrixBlocks(columns, np.flatnonzero(sizes[label] == 1), larger)


def bit_sets(membership: Bools) -> list[int]:
    """Each row of ``membership`` (N, M) as a bit set: bit k for column k."""
    packed = np.packbits(membership, axis=1, bitorder="little")
    return [int.from_bytes(row.tobytes(), "little") for row in packed]


def _strong_components(onward: Bools) -> Rows:
    """(N,) number of the strong component of each node of the graph a -> b where ``onward`` (N, N)."""
    back = bit_sets(onward.T)
    left = (1 << len(onward)) - 1
    label = [0] * len(onward)
    count = 0
    for start in reversed(_finishing_order(bit_sets(onward))):
        waiting = left & 1 << start
        if not waiting:
            continue
        while waiting:
            low = waiting & -waiting
            left ^= low
            node = low.bit_length() - 1
            label[node] = count
            waiting = (waiting | back[node]) & left
        count += 1
    return np.array(label)


def _finishing_order(onward: Sequence[int]) -> list[int]:
    """Nodes in the order in which a depth-first search leaves them."""
    left = (1 << len(onward)) - 1
    order = []
    while left:
        start = left & -left
        left ^= start
        path = [start.bit_length() - 1]
        while path:
            free = onward[path[-1]] & left
            if not free:
                order.append(path.pop())
                continue
            low = free & -free
            left ^= low
            path.append(low.bit_length() - 1)
    return order
