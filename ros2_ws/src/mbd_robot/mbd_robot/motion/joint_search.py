"""A way through the joints' space where the straight ones are blocked: RRT-Connect, then shortcuts.

Two trees grow towards each other from both ends of the way (Kuffner and LaValle, RRT-Connect, ICRA 2000). Without an
end in sight it gives up after a number of samples; that it found none does not show that there is none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

STEP = 0.04  # [rad] of the joint that moves most, between two points that are looked at
REACHED = 1e-9  # [rad]
SHORTCUTS = 60  # tried on a way that was found

Joints = NDArray[np.float64]


def connect(
    start: Joints, goal: Joints, samples: Iterator[Joints], free: Callable[[Joints], bool], rng: np.random.Generator
) -> Joints | None:
    """The corners of a free way, the joints moving straight between them; None when the samples ended before.

    Args:
        start: (J,) [rad] where it begins, which need not be free.
        goal: (J,) [rad] where it ends.
        samples: (J,) [rad] each, towards which the trees grow.
        free: whether the arm may be there.
        rng: chooses the shortcuts.

    Returns:
        (N, J) [rad] from start to goal.
    """
    if not free(goal):
        return None
    trees = (_Tree(start), _Tree(goal))
    for turn, sample in enumerate(samples):
        one, other = trees if turn % 2 == 0 else trees[::-1]
        new = one.grow(sample, free)
        met = other.grow(one.nodes[new], free)
        if np.abs(other.nodes[met] - one.nodes[new]).max() < REACHED:
            first, second = (one, new), (other, met)
            if one is not trees[0]:
                first, second = second, first
            way = [*reversed(first[0].back(first[1])), *second[0].back(second[1])[1:]]
            return _shortened(np.array(way), free, rng)
    return None


class _Tree:
    """Joint angles reached so far, each from its parent by a free straight way."""

    def __init__(self, root: Joints) -> None:
        self.nodes: list[Joints] = [root]
        self._parents = [-1]

    def grow(self, towards: Joints, free: Callable[[Joints], bool]) -> int:
        """Go from the nearest node towards there as far as it is free; the index of the last node."""
        at = int(np.linalg.norm(np.array(self.nodes) - towards, axis=1).argmin())
        for point in between(self.nodes[at], towards):
            if not free(point):
                break
            self.nodes.append(point)
            self._parents.append(at)
            at = len(self.nodes) - 1
        return at

    def back(self, index: int) -> list[Joints]:
        """The nodes from that one to the root."""
        found = []
        while index >= 0:
            found.append(self.nodes[index])
            index = self._parents[index]
        return found


def between(one: Joints, other: Joints) -> Iterator[Joints]:
    """Points on the straight way, the first left out, the last ``other`` itself."""
    count = int(np.ceil(np.abs(other - one).max() / STEP))
    for k in range(1, count + 1):
        yield other if k == count else one + (other - one) * k / count


def _shortened(way: Joints, free: Callable[[Joints], bool], rng: np.random.Generator) -> Joints:
    """The way with corners cut off where the straight way between two of its points is free."""
    points = list(way)
    for _ in range(SHORTCUTS):
        if len(points) < 3:
            break
        i, k = sorted(int(v) for v in rng.choice(len(points), 2, replace=False))
        if k > i + 1 and all(free(point) for point in between(points[i], points[k])):
            del points[i + 1 : k]
    return np.array(points)
