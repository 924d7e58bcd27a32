"""The teacher who takes the objects in turn, for more objects than a permanent can be summed over.

For row after row one of the columns left is taken, j with probability weights_ij over the sum of what is left: the
probabilities of all mappings sum to 1 without a permanent. The rows told come first, so that what was told is
conditioned on exactly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.strategy import Pair
from mbd_mapping.tables import Floats

TINY = 1e-200
ROUNDS = 12
# Multiplications of a product up to which OpenBLAS does it alone. Larger ones it shares out, and threads that wait for
# each other a hundred times in one inference cost fifty times the work as soon as other programs run.
ONE_THREAD = 200_000


def turn_order(size: int, pairs: Sequence[Pair]) -> list[int]:
    """The rows in the order they are taken: those told in row order, then the others."""
    told = {row for row, _ in pairs}
    return sorted(told) + [row for row in range(size) if row not in told]


def log_of_mappings(by_row: Floats, mappings: Columns, order: Sequence[int]) -> Floats:
    """(H, C): log probability of each square mapping (C, N) under the weights ``by_row`` (N, H, N) of each row."""
    count, size = mappings.shape
    left = np.ones((size, count))
    logs = np.zeros((by_row.shape[1], count))
    every = np.arange(count)
    step = max(1, ONE_THREAD // (size * count))
    free = np.empty_like(logs)
    for row in order:
        column = mappings[:, row]
        for first in range(0, len(free), step):
            np.matmul(by_row[row, first : first + step], left, out=free[first : first + step])
        logs += np.log(np.maximum(by_row[row][:, column], TINY) / np.maximum(free, TINY))
        left[column, every] = 0.0
    return logs


def log_of_told(weights: Floats, likelihood: Floats, pairs: Sequence[Pair]) -> Floats:
    """(H,): log probability of what was told about each row, a column told being taken by the rows after it."""
    size = weights.shape[1]
    left = np.ones(size)
    logs = np.zeros(len(weights))
    told: dict[int, list[int]] = {}
    for row, column in pairs:
        told.setdefault(row, []).append(column)
    changed = np.flatnonzero((likelihood != 1.0).any(axis=1))
    for row in sorted({*told, *changed.tolist()}, key=lambda r: (r not in told, r)):
        share = weights[:, row, :] * left
        total = np.maximum(share.sum(axis=1), TINY)
        logs += np.log(np.maximum(share @ likelihood[row] / total, TINY))
        columns = told.get(row, [])
        if len(columns) == 1:
            left[columns[0]] = 0.0
    return logs


def shares_in_turn(weights: Floats) -> Floats:
    """(H, N, N): about how probable each pair is, by scaling rows and columns to sum 1."""
    positive = weights + TINY
    of_column = np.ones(weights.shape[:2])
    for _ in range(ROUNDS):
        of_row = 1.0 / np.einsum("hij,hj->hi", positive, of_column)
        of_column = 1.0 / np.einsum("hij,hi->hj", positive, of_row)
    share: Floats = positive * of_row[:, :, None] * of_column[:, None, :]
    return share
