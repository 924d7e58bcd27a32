"""The blocks a matrix of weights falls into: pairs of two blocks are never in one assignment of weight together.

With one perfect matching of the pairs of weight, let row a point to the row that owns column b wherever (a, b) has
weight. A pair is in some perfect matching exactly when its two rows lie on a closed walk: the strong components of that
graph are the blocks, and the permanent is the product of theirs (Dulmage and Mendelsohn 1958).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from mbd_mapping.tables import Floats

Rows = NDArray[np.intp]


def blocks_of(weights: Floats) -> list[tuple[Rows, Rows]] | None:
    """(rows, columns) of each block of ``weights`` (N, N); None when no assignment has weight."""
    size = len(weights)
    support = weights > 0
    if support.all():
        every = np.arange(size)
        return [(every, every)]
    column_of = np.asarray(maximum_bipartite_matching(csr_matrix(support), perm_type="column"), dtype=np.intp)
    if (column_of < 0).any():
        return None
    count, label = connected_components(
        csr_matrix(support[:, column_of].astype(np.int8)), directed=True, connection="strong"
    )
    order = np.argsort(label, kind="stable")
    rows = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
    return [(r, column_of[r]) for r in rows]
