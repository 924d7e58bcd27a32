"""Sums over all assignments: permanents of many small matrices at once, and the marginals of their pairs.

Up to EXACT_SIZE rows the sum is exact, by dynamic programming over the sets of columns already taken: N 2^N products a
matrix in place of N!. Beyond, an approximation from below: Sinkhorn scaling with the bound of Gurvits and Samorodnitsky
(2014), O(N^2) a round; exact for a single mapping.
"""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mbd_mapping.tables import Floats

EXACT_SIZE = 11
SCALING_ROUNDS = 200
SCALING_ERROR = 1e-3
TINY = 1e-300


@cache
def _steps(size: int) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]], ...]:
    """For each row: the sets of columns after it, those sets without each of their columns, and that column."""
    steps = []
    for row in range(size):
        chosen = list(itertools.combinations(range(size), row + 1))
        after = np.array([sum(1 << c for c in columns) for columns in chosen])
        column = np.array(chosen)
        before = after[:, None] - (1 << column)
        steps.append((after, before, column))
    return tuple(steps)


def log_permanents(weights: Floats) -> Floats:
    """Logarithms of the permanents of ``weights`` (H, N, N), all >= 0; returns (H,), -inf where a permanent is 0.

    Exact up to EXACT_SIZE, else from below.
    """
    size = weights.shape[1]
    if size > EXACT_SIZE:
        return _scaled(weights)[0]
    largest = weights.max(axis=2, keepdims=True, initial=TINY)
    reached = _forward(np.ascontiguousarray((weights / largest).transpose(1, 2, 0)))[-1]
    with np.errstate(divide="ignore"):
        logs: Floats = np.log(reached) + np.log(largest).sum(axis=(1, 2))
    return logs


def _forward(columns_first: Floats) -> Floats:
    """(2^N, H): sum over the assignments of the first rows to each set of columns; weights as (N, N, H)."""
    size, _, count = columns_first.shape
    reached = np.zeros((1 << size, count))
    reached[0] = 1.0
    for row, (after, before, column) in enumerate(_steps(size)):
        reached[after] = np.einsum("sch,sch->sh", reached[before], columns_first[row][column])
    return reached


def marginals(weights: Floats) -> Floats:
    """(H, N, N): the share of each pair in the permanent; zeros where that is 0."""
    count, size, _ = weights.shape
    if size > EXACT_SIZE:
        return _scaled(weights)[1]
    largest = weights.max(axis=2, keepdims=True, initial=TINY)
    columns_first = np.ascontiguousarray((weights / largest).transpose(1, 2, 0))
    forward = _forward(columns_first)
    backward = np.zeros((1 << size, count))
    backward[-1] = 1.0
    share = np.zeros((size, size, count))
    for row in reversed(range(size)):
        after, before, column = _steps(size)[row]
        onward = columns_first[row][column] * backward[after][:, None, :]
        np.add.at(share[row], column, forward[before] * onward)
        np.add.at(backward, before, onward)
    total = forward[-1]
    safe = np.where(total > 0, total, 1.0)
    return np.where(total > 0, share / safe, 0.0).transpose(2, 0, 1)


def _scaled(weights: Floats) -> tuple[Floats, Floats]:
    """Approximate log permanents (H,) and marginals (H, N, N): scale rows and columns to sum 1, bound what is left.

    A doubly stochastic S has per(S) >= prod (1 - s)^(1 - s), and at most 2^N times that.
    """
    largest = weights.max(axis=2, keepdims=True, initial=TINY)
    scaled = weights / largest
    log_scale = np.log(largest).sum(axis=(1, 2))
    for _ in range(SCALING_ROUNDS):
        rows = np.maximum(scaled.sum(axis=2, keepdims=True), TINY)
        scaled = scaled / rows
        columns = np.maximum(scaled.sum(axis=1, keepdims=True), TINY)
        scaled = scaled / columns
        log_scale += np.log(rows).sum(axis=(1, 2)) + np.log(columns).sum(axis=(1, 2))
        if np.abs(columns - 1.0).max() < SCALING_ERROR:
            break
    left = np.maximum(1.0 - scaled, TINY)
    return log_scale + (left * np.log(left)).sum(axis=(1, 2)), scaled
