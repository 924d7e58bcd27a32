"""Two pieces on both sides of what stands before them: how much speaks for one object behind it.

A thing cut in two by an occluder goes on behind it: its face is the same plane, or the same lying cylinder, on both
sides; it is as wide; and between the pieces nothing is seen but the occluder and its shadow, least of all the table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mbd_perception.quantile import quantile
from mbd_perception.segmentation.borders import Borders, PairTable, Relief
from mbd_perception.segmentation.joining.faces import SMALLEST, joint_error
from mbd_perception.segmentation.joining.ways import SeenWays, nearest, squared_distances
from mbd_perception.segmentation.regions import Regions

# About how many pixels of a region are looked at.
SAMPLE = 120
# The logarithm of the misfit is no less.
BEST = -1.0
# At least this share of the way between them lies behind something, and at most this share shows the table.
HIDDEN, TABLE = 0.75, 0.2
# What is narrower than this share of both together is a shadow at a silhouette: two things that all but touch.
NARROW = 0.1
# With so many points of each piece most pairs are ruled out: by less than this share of what is asked for.
FEW, ROUGHLY = 24, 0.5
# What is wider hides more than is seen: two of a row of equal things.
WIDE = 0.6


@dataclass(frozen=True)
class PieceFeatures:
    """What is measured of a pair of pieces.

    Attributes:
        misfit: by how much one face through both misses them, in what noise and unevenness allow; log scale.
        hidden: share of the way between them that the occluder or its shadow covers.
        table: share of that way on which the table is seen.
        breadth: overlap of their extents across that way, 0..1.
        gap: length of that way over the length of both together.
        chroma: difference of colour (CIE a b, 8-bit scale), at most 60.
        top: difference of their tops over the higher one.
        size: area of the smaller over that of the larger.
    """

    misfit: float
    hidden: float
    table: float
    breadth: float
    gap: float
    chroma: float
    top: float
    size: float


class Pieces:
    """Groups of regions of one picture, to be compared two by two.

    Args:
        regions: of the picture at half size.
        borders: between them.
        relief: of the same picture.
        groups: (count + 1,) group of each region.
        colors: (count + 1, 3) mean CIE L a b of each region.
        tops: (count + 1,) heights of the regions' tops [m].
        noise: std of inverse depth [1/m].
    """

    def __init__(
        self,
        regions: Regions,
        borders: Borders,
        relief: Relief,
        *,
        groups: NDArray[np.int32],
        colors: PairTable,
        tops: PairTable,
        noise: float,
    ) -> None:
        self._relief, self._noise = relief, noise
        self.groups = groups
        self._members = {int(g): np.flatnonzero(groups == g) for g in np.unique(groups) if g}
        self._points: dict[int, NDArray[np.float64]] = {}
        self._middles: dict[int, NDArray[np.float64]] = {}
        self._nearest: dict[tuple[int, int], tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._pixels = regions.pixels
        area = np.array([0] + [len(p) for p in self._pixels], dtype=np.float64)
        self._area, self._colors, self._tops = area, colors, tops
        labels = regions.labels
        self.picture = groups[labels]
        self._ways = SeenWays(relief, self.picture, step=4.0 * noise)
        self._shape = labels.shape

    def candidates(self) -> list[tuple[int, int]]:
        """Each two pieces that something before them separates: no table and no third thing is seen between them."""
        area = {g: float(self._area[m].sum()) for g, m in self._members.items()}
        numbers = [g for g in sorted(self._members) if area[g] >= SMALLEST]
        found = []
        for first, second in self._worth_a_look(numbers):
            hidden, table = self._ways.between(*self._ends(first, second))
            if hidden >= HIDDEN and table <= TABLE and NARROW <= self._gap(first, second) <= WIDE:
                found.append((first, second))
        return found

    def _worth_a_look(self, numbers: list[int]) -> list[tuple[int, int]]:
        """Pairs of groups that a few points of each do not rule out: what lies between those is a rough guess."""
        if len(numbers) < 2:
            return []
        count = len(numbers)
        few = np.stack([p[np.linspace(0, len(p) - 1, FEW).astype(int)] for p in map(self._coordinates, numbers)])
        flat = few.reshape(-1, 2)
        squared = squared_distances(flat, flat).reshape(count, FEW, count, FEW)
        one, other = np.triu_indices(count, 1)
        closest = squared[one, :, other].reshape(len(one), -1).argmin(axis=1)
        start, end = few[one, closest // FEW], few[other, closest % FEW]
        share = (np.arange(FEW) + 0.5) / FEW
        u, v = np.rint(start[..., None] + (end - start)[..., None] * share).astype(int).transpose(1, 0, 2)
        nearer, shadow, table = self._ways.on(u, v, start.astype(int), end.astype(int), share)
        hidden = (nearer | shadow).mean(axis=1)
        keep = (hidden >= ROUGHLY * HIDDEN) & (table.mean(axis=1) <= TABLE / ROUGHLY)
        return [(numbers[a], numbers[b]) for a, b in zip(one[keep].tolist(), other[keep].tolist(), strict=True)]

    def compare(self, first: int, second: int) -> PieceFeatures:
        """The features of two pieces."""
        return replace(self.compare_outlines(first, second), misfit=self.misfit(first, second))

    def compare_outlines(self, first: int, second: int) -> PieceFeatures:
        """The same without looking at their faces, which costs the most: they are taken to fit as well as can be."""
        one, other = self._coordinates(first), self._coordinates(second)
        start, end = self._ends(first, second)
        hidden, table = self._ways.between(start, end)
        along = self._along(first, second)
        across = np.array([-along[1], along[0]])
        a, b = ([quantile(p @ across, share) for share in (0.05, 0.95)] for p in (one, other))
        shared = max(min(a[1], b[1]) - max(a[0], b[0]), 0.0)
        colors = [self._area[m] @ self._colors[m] / self._area[m].sum() for m in map(self._of, (first, second))]
        tops = [float(self._tops[self._of(g)].max()) for g in (first, second)]
        areas = sorted(float(self._area[self._of(g)].sum()) for g in (first, second))
        return PieceFeatures(
            misfit=BEST,
            hidden=hidden,
            table=table,
            breadth=shared / max(max(a[1], b[1]) - min(a[0], b[0]), 1.0),
            gap=self._gap(first, second),
            chroma=min(float(np.linalg.norm(colors[0][1:] - colors[1][1:])), 60.0),
            top=abs(tops[0] - tops[1]) / max(*tops, 1e-3),
            size=areas[0] / max(areas[1], 1.0),
        )

    def _ends(self, first: int, second: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The nearest points of two pieces."""
        key = (first, second)
        if key not in self._nearest:
            self._nearest[key] = nearest(self._coordinates(first), self._coordinates(second))
        return self._nearest[key]

    def _along(self, first: int, second: int) -> NDArray[np.float64]:
        """(2,) unit vector from the middle of one piece to that of the other."""
        along = self._middle(second) - self._middle(first)
        unit: NDArray[np.float64] = along / max(float(np.linalg.norm(along)), 1e-9)
        return unit

    def _gap(self, first: int, second: int) -> float:
        """Shortest way between two pieces over the length of both together, from middle to middle."""
        one, other = self._coordinates(first), self._coordinates(second)
        start, end = self._ends(first, second)
        along = self._along(first, second)
        reach, further = one @ along, other @ along
        length = max(float(reach.max()), float(further.max())) - min(float(reach.min()), float(further.min()))
        return math.dist(end, start) / max(length, 1.0)

    def _of(self, group: int) -> NDArray[np.intp]:
        return self._members[group]

    def _sample(self, region: int) -> NDArray[np.intp]:
        pixels = self._pixels[region - 1]
        return pixels[:: max(1, len(pixels) // SAMPLE)]

    def _coordinates(self, group: int) -> NDArray[np.float64]:
        """(k, 2) u, v of about SAMPLE pixels of each region of the group."""
        if group not in self._points:
            pixels = np.concatenate([self._sample(int(r)) for r in self._of(group)])
            v, u = np.divmod(pixels, self._shape[1])
            self._points[group] = np.stack([u, v], axis=1).astype(np.float64)
        return self._points[group]

    def _middle(self, group: int) -> NDArray[np.float64]:
        """(2,) mean of the points of a group."""
        if group not in self._middles:
            self._middles[group] = self._coordinates(group).mean(axis=0)
        return self._middles[group]

    def misfit(self, first: int, second: int) -> float:
        """Log of the error of one face through the best two faces, over the noise and the faces' own unevenness."""
        along, best = self._along(first, second), np.inf
        smaller = min(float(self._area[self._of(g)].sum()) for g in (first, second))
        for a in self._of(first):
            for b in self._of(second):
                if min(self._area[a], self._area[b]) < max(SMALLEST, 0.2 * smaller):
                    continue
                one, other = self._sample(int(a)), self._sample(int(b))
                best = min(best, joint_error(self._relief, one, other, along, noise=self._noise))
        return float(np.clip(np.log(best), BEST, 5.0))
