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
    for row in order:
        column = mappings[:, row]
        free = np.maximum(by_row[row] @ left, TINY)
        logs += np.log(np.maximum(by_row[row][:, column], TINY) / free)
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
    turned = positive.transpose(0, 2, 1)
    of_column = np.ones((*weights.shape[:2], 1))
    for _ in range(ROUNDS):
        of_row = 1.0 / (positive @ of_column)
        of_column = 1.0 / (turned @ of_row)
    share: Floats = positive * of_row * of_column.transpose(0, 2, 1)
    return share
