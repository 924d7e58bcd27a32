"""What is seen on straight ways across the picture, from one piece to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.segmentation.borders import Relief

Mask = NDArray[np.bool_]
Pixels = NDArray[np.intp]


@dataclass(frozen=True)
class SeenWays:
    """A picture that ways lead across.

    Attributes:
        relief: of the picture.
        picture: (H, W) group of each pixel, 0 for none.
        step: by which inverse depth must be larger for something nearer [1/m].
    """

    relief: Relief
    picture: NDArray[np.int32]
    step: float

    def between(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> tuple[float, float]:
        """(share of the straight way on which something nearer or a shadow is seen, share on which the table is)."""
        steps = max(int(np.linalg.norm(end - start)), 2)
        share = np.linspace(0.0, 1.0, steps + 1)[1:-1]
        u, v = np.rint(start + share[:, None] * (end - start)).astype(int).T
        nearer, shadow, table = self.on(u, v, start.astype(int), end.astype(int), share)
        return float((nearer | shadow).mean()), float(table.mean())

    def on(
        self, u: Pixels, v: Pixels, start: Pixels, end: Pixels, share: NDArray[np.float64]
    ) -> tuple[Mask, Mask, Mask]:
        """Where on ways from ``start`` to ``end``, (..., 2), something nearer, a shadow, the table is seen.

        Args:
            u: (..., n) columns of the ways' pixels.
            v: (..., n) their rows.
            start: (..., 2) u, v of their first ends.
            end: (..., 2) of their last.
            share: (n,) of the way to each pixel.
        """
        w = self.relief.w
        first, last = w[start[..., 1], start[..., 0]][..., None], w[end[..., 1], end[..., 0]][..., None]
        seen = w[v, u]
        nearer = seen > first + share * (last - first) + self.step
        table = self.relief.table[v, u]
        return nearer, (seen <= 0) | ((self.picture[v, u] == 0) & ~table), table


def nearest(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The two points, one of each set, that are nearest to each other."""
    a, b = divmod(int(squared_distances(one, other).argmin()), len(other))
    return one[a], other[b]


def squared_distances(one: NDArray[np.float64], other: NDArray[np.float64]) -> FloatImage:
    """(n, m) squared distances of points."""
    # Pixels are integers: the sums are exact, in single precision too.
    first, second = one.astype(np.float32), other.astype(np.float32)
    squared = np.asarray((np.float32(-2.0) * first) @ second.T, dtype=np.float32)
    squared += np.einsum("ij,ij->i", second, second)
    squared += np.einsum("ij,ij->i", first, first)[:, None]
    return squared
