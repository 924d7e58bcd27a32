"""Teachers who go by order: the first to the first, the second to the second, whatever the distances between them.

Ranks are normalised, rank / (count - 1), so that scenes of different size are matched end to end and in order: the
score of a pair falls with the square of the difference of its ranks, which makes every best mapping order-preserving.
Objects whose values differ by no more than they are measured share their ranks softly: the rank of an object is the
expected number of objects before it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import ndtr

from mbd_mapping.tables import Floats, ObjectTable
from mbd_mapping.teachers.priors import Group

SIZE_ERROR = 0.07  # [log volume]: edges to 4 %
PLACE_ERROR = 0.01  # [m]
ROW_GAP = 0.05  # [m]: objects farther apart in depth than this stand in different rows
RANK_SCALE = 0.34  # as sigma of eq. 2: a difference of all ranks scores as a difference of a whole range


def expected_ranks(values: Floats, error: float) -> Floats:
    """(n,) normalised rank 0..1 of values (n,) each measured with a standard deviation ``error``."""
    count = len(values)
    if count < 2:
        return np.zeros(count)
    before = ndtr((values[:, None] - values[None, :]) / (np.sqrt(2.0) * error))
    np.fill_diagonal(before, 0.0)
    ranks: Floats = before.sum(axis=1) / (count - 1)
    return ranks


def rows_of(depth: Floats) -> Floats:
    """(n,) number of the row each object stands in, the nearest 0, by gaps in depth [m]."""
    order = np.argsort(depth, kind="stable")
    rows = np.zeros(len(depth))
    rows[order[1:]] = np.cumsum(np.diff(depth[order]) > ROW_GAP)
    return rows


def order_scores(source: ObjectTable, target: ObjectTable) -> Iterator[tuple[Group, Floats]]:
    """(group, score (n, m)) of each order in which the source objects differ."""
    ranks = [(_size_ranks(source), _size_ranks(target))]
    if source.positions is not None and target.positions is not None:
        ranks += zip(_place_ranks(source.positions), _place_ranks(target.positions), strict=True)
    for place, (a, b) in enumerate(ranks):
        if len(a) < 2 or np.ptp(a) < 1e-6:
            continue
        yield Group.ORDER, _score(a, b)
        if place < 3:  # row by row has no mirror image of its own
            yield Group.REVERSED, _score(a, 1.0 - b)


def _size_ranks(table: ObjectTable) -> Floats:
    return expected_ranks(np.log(table.volume), SIZE_ERROR)


def _place_ranks(positions: Floats) -> list[Floats]:
    """Left to right, near to far, and row by row from the nearest or the farthest row, each from the left."""
    depth, right = positions[:, 0], -positions[:, 1]
    rows, span = rows_of(depth), 2.0 * (np.ptp(right) + 1.0) if len(right) else 1.0
    near = expected_ranks(rows * span + right, PLACE_ERROR)
    far = expected_ranks(-rows * span + right, PLACE_ERROR)
    return [expected_ranks(right, PLACE_ERROR), expected_ranks(depth, PLACE_ERROR), near, far]


def _score(source: Floats, target: Floats) -> Floats:
    score: Floats = 1.0 - 0.5 * ((source[:, None] - target[None, :]) / RANK_SCALE) ** 2
    return score
