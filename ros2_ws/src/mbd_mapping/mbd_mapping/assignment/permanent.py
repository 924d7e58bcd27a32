"""Sums over all assignments: permanents of many small matrices at once, and the marginals of their pairs.

Up to EXACT_SIZE rows the sum is exact, by dynamic programming over the sets of columns already taken: N 2^N products a
matrix in place of N!. A larger matrix falls into the blocks whose pairs can be in an assignment together
(``blocks.py``); each block of at most EXACT_SIZE is exact, a larger one is scaled by Sinkhorn's rounds and bounded as
by Gurvits and Samorodnitsky (2014), times sqrt(2 pi N / e), by which that bound falls short where all pairs are alike.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mbd_mapping.assignment.blocks import blocks_of
from mbd_mapping.tables import Floats

EXACT_SIZE = 11
SCALING_ROUNDS = 100
SCALING_ERROR = 1e-4
TINY = 1e-300


@cache
def _steps(size: int) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]], ...]:
    """For each row: the sets before it (N, S) that lack each column, the sets with it, and a scatter-free view.

    The last two are, for each set of columns after the row, the places of its parts among (N, S) flattened.
    """
    every = np.arange(1 << size)
    count = np.array([int(s).bit_count() for s in every])
    steps = []
    for row in range(size):
        sets = every[count == row]
        before = np.array([sets[(sets >> c) & 1 == 0] for c in range(size)])
        after = before | (1 << np.arange(size))[:, None]
        order = np.argsort(after.ravel(), kind="stable").reshape(-1, row + 1)
        steps.append((before, after, np.unique(after), order))
    return tuple(steps)


def log_permanents(weights: Floats) -> Floats:
    """Logarithms of the permanents of ``weights`` (H, N, N), all >= 0; returns (H,), -inf where a permanent is 0."""
    return sums(weights, with_marginals=False)[0]


def marginals(weights: Floats) -> Floats:
    """(H, N, N): the share of each pair in the permanent; zeros where that is 0."""
    return sums(weights)[1]


def sums(weights: Floats, with_marginals: bool = True) -> tuple[Floats, Floats]:
    """(log permanents (H,), marginals (H, N, N)) of ``weights`` (H, N, N), all >= 0; marginals empty if not wanted."""
    size = weights.shape[1]
    if not len(weights):
        return np.zeros(0), np.zeros((0, size, size))
    if size > EXACT_SIZE:
        return _by_blocks(weights)
    largest = weights.max(axis=2, keepdims=True, initial=TINY)
    columns_first = np.ascontiguousarray((weights / largest).transpose(1, 2, 0))
    forward = _forward(columns_first)
    with np.errstate(divide="ignore"):
        logs: Floats = np.log(forward[-1]) + np.log(largest).sum(axis=(1, 2))
    return logs, _shares(columns_first, forward) if with_marginals else np.zeros((0, size, size))


def _forward(columns_first: Floats) -> Floats:
    """(2^N, H): sum over the assignments of the first rows to each set of columns; weights as (N, N, H)."""
    size, _, count = columns_first.shape
    reached = np.zeros((1 << size, count))
    reached[0] = 1.0
    for row, (before, _, sets, order) in enumerate(_steps(size)):
        moved = (reached[before] * columns_first[row][:, None, :]).reshape(-1, count)
        reached[sets] = moved[order].sum(axis=1)
    return reached


def _shares(columns_first: Floats, forward: Floats) -> Floats:
    """(H, N, N) marginals from the sums forward, with the sums backward."""
    size, _, count = columns_first.shape
    backward = np.zeros((1 << size, count))
    backward[-1] = 1.0
    share = np.zeros((size, size, count))
    full = (1 << size) - 1
    for row in reversed(range(size)):
        before, after, _, _ = _steps(size)[row]
        onward = columns_first[row][:, None, :] * backward[after]
        share[row] = (forward[before] * onward).sum(axis=1)
        # A set lacks N - row columns: its parts are those of its complement among the sets after the row.
        sets = np.unique(before)
        order = np.argsort((full - before).ravel(), kind="stable").reshape(len(sets), size - row)
        backward[full - np.sort(full - sets)] = onward.reshape(-1, count)[order].sum(axis=1)
    total = forward[-1]
    safe = np.where(total > 0, total, 1.0)
    return np.where(total > 0, share / safe, 0.0).transpose(2, 0, 1)


def _by_blocks(weights: Floats) -> tuple[Floats, Floats]:
    """The same for large matrices: the product over the blocks of each, blocks of one size together."""
    logs, share = np.zeros(len(weights)), np.zeros_like(weights)
    by_size: dict[int, list[tuple[int, NDArray[np.intp], NDArray[np.intp]]]] = {}
    for h, support in enumerate(weights > 0):
        blocks = blocks_of(support)
        if blocks is None:
            logs[h] = -np.inf
            continue
        alone = blocks.single, blocks.columns[blocks.single]
        logs[h] = np.log(weights[h][alone]).sum()
        share[h][alone] = 1.0
        for rows in blocks.larger:
            by_size.setdefault(len(rows), []).append((h, rows, blocks.columns[rows]))
    for size, members in by_size.items():
        owner = np.array([h for h, _, _ in members])
        rows = np.array([r for _, r, _ in members])[:, :, None]
        columns = np.array([c for _, _, c in members])[:, None, :]
        parts = weights[owner[:, None, None], rows, columns]
        found, shares = sums(parts) if size <= EXACT_SIZE else _scaled(parts)
        np.add.at(logs, owner, found)
        share[owner[:, None, None], rows, columns] = shares
    return logs, share


def _scaled(weights: Floats) -> tuple[Floats, Floats]:
    """Approximate log permanents (H,) and marginals (H, N, N) of blocks in which no pair stands for itself.

    A doubly stochastic S has per(S) >= prod (1 - s)^(1 - s); where all pairs are alike sqrt(2 pi N / e) times that.
    """
    largest = weights.max(axis=2, keepdims=True, initial=TINY)
    scaled = weights / largest
    # Only the factors of rows and columns change from round to round: a product of matrix and vector each.
    of_row, of_column = np.ones((2, *weights.shape[:2]))
    for _ in range(SCALING_ROUNDS):
        of_row = 1.0 / np.maximum(np.einsum("hij,hj->hi", scaled, of_column), TINY)
        before, of_column = of_column, 1.0 / np.maximum(np.einsum("hij,hi->hj", scaled, of_row), TINY)
        if np.abs(before / of_column - 1.0).max() < SCALING_ERROR:
            break
    scaled = scaled * of_row[:, :, None] * of_column[:, None, :]
    log_scale = np.log(largest).sum(axis=(1, 2)) - (np.log(of_row) + np.log(of_column)).sum(axis=1)
    left = np.maximum(1.0 - scaled, TINY)
    short = 0.5 * np.log(2.0 * np.pi * weights.shape[1] / np.e)
    return log_scale + (left * np.log(left)).sum(axis=(1, 2)) + short, scaled
