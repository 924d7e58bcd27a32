"""Two pieces on both sides of what stands before them: how much speaks for one object behind it.

A thing cut in two by an occluder goes on behind it: its face is the same plane, or the same lying cylinder, on both
sides; it is as wide; and between the pieces nothing is seen but the occluder and its shadow, least of all the table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.quantile import median, quantile
from mbd_perception.segmentation.borders import Borders, PairTable, Relief
from mbd_perception.segmentation.joining import rejoin_weights
from mbd_perception.segmentation.regions import Regions

Mask = NDArray[np.bool_]
Pixels = NDArray[np.intp]

# About how many pixels of a region are looked at.
SAMPLE = 120
# A face of fewer pixels says nothing about how it goes on.
SMALLEST = 12
RIDGE = 1e-12 * np.eye(4)
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
        self._step = 4.0 * noise
        self._shape = labels.shape

    def candidates(self) -> list[tuple[int, int]]:
        """Each two pieces that something before them separates: no table and no third thing is seen between them."""
        area = {g: float(self._area[m].sum()) for g, m in self._members.items()}
        numbers = [g for g in sorted(self._members) if area[g] >= SMALLEST]
        found = []
        for first, second in self._worth_a_look(numbers):
            hidden, table = self._between(*self._ends(first, second))
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
        squared = _squared_distances(flat, flat).reshape(count, FEW, count, FEW)
        one, other = np.triu_indices(count, 1)
        nearest = squared[one, :, other].reshape(len(one), -1).argmin(axis=1)
        start, end = few[one, nearest // FEW], few[other, nearest % FEW]
        share = (np.arange(FEW) + 0.5) / FEW
        u, v = np.rint(start[..., None] + (end - start)[..., None] * share).astype(int).transpose(1, 0, 2)
        nearer, shadow, table = self._seen_on(u, v, start.astype(int), end.astype(int), share)
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
        hidden, table = self._between(start, end)
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
            self._nearest[key] = _nearest(self._coordinates(first), self._coordinates(second))
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

    def _between(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> tuple[float, float]:
        """(share of the straight way on which something nearer or a shadow is seen, share on which the table is)."""
        steps = max(int(np.linalg.norm(end - start)), 2)
        share = np.linspace(0.0, 1.0, steps + 1)[1:-1]
        u, v = np.rint(start + share[:, None] * (end - start)).astype(int).T
        nearer, shadow, table = self._seen_on(u, v, start.astype(int), end.astype(int), share)
        return float((nearer | shadow).mean()), float(table.mean())

    def _seen_on(
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
        w = self._relief.w
        first, last = w[start[..., 1], start[..., 0]][..., None], w[end[..., 1], end[..., 0]][..., None]
        seen = w[v, u]
        nearer = seen > first + share * (last - first) + self._step
        table = self._relief.table[v, u]
        return nearer, (seen <= 0) | ((self.picture[v, u] == 0) & ~table), table

    def misfit(self, first: int, second: int) -> float:
        """Log of the error of one face through the best two faces, over the noise and the faces' own unevenness."""
        along, best = self._along(first, second), np.inf
        smaller = min(float(self._area[self._of(g)].sum()) for g in (first, second))
        for a in self._of(first):
            for b in self._of(second):
                if min(self._area[a], self._area[b]) < max(SMALLEST, 0.2 * smaller):
                    continue
                best = min(best, self._joint_error(int(a), int(b), along))
        return float(np.clip(np.log(best), BEST, 5.0))

    def _joint_error(self, a: int, b: int, along: NDArray[np.float64]) -> float:
        """Median error of a face through two regions that is straight along ``along`` and may bend across."""
        one, other = self._sample(a), self._sample(b)
        values = self._relief.w.ravel()
        one, other = one[values[one] > 0], other[values[other] > 0]
        if min(len(one), len(other)) < SMALLEST:
            return np.inf
        pixels = np.concatenate([one, other])
        v, u = np.divmod(pixels, self._shape[1])
        scale = 1.0 / self._relief.focal
        t, s = ((u * along[0] + v * along[1]) * scale), ((v * along[0] - u * along[1]) * scale)
        t, s = t - t.mean(), s - s.mean()
        terms = np.stack([np.ones(len(t)), t, s, s * s], axis=1)
        w = values[pixels].astype(np.float64)
        # Each region counts the same, however many of its pixels are looked at.
        weight = np.concatenate([np.full(len(one), 1.0 / len(one)), np.full(len(other), 1.0 / len(other))])
        errors = [np.inf, np.inf]
        for _ in range(2):
            weighted = terms.T * weight
            # A little regularised: a strip one pixel wide does not bend across.
            fit = np.linalg.solve(weighted @ terms + RIDGE, weighted @ w)
            error = np.abs(terms @ fit - w)
            errors = [median(error[: len(one)]), median(error[len(one) :])]
            weight = weight / (1.0 + (error / max(3.0 * self._noise, 2.0 * max(errors))) ** 2)
        return max(errors) / (0.6745 * self._noise)


# What the model is given of a pair, in this order.
TERMS = ("misfit", "breadth", "top", "open_way", "chroma")


def model_row(features: PieceFeatures) -> tuple[float, ...]:
    """``TERMS``: misfit; 1 - breadth; top; the way that is not hidden plus that with the table; chroma / 30."""
    return (
        features.misfit,
        1.0 - features.breadth,
        features.top,
        1.0 - features.hidden + features.table,
        features.chroma / 30.0,
    )


@dataclass(frozen=True)
class RejoinConfig:
    """Log-odds that two pieces are one thing cut in two by what stands before them: a logistic model.

    `train_rejoin` fits it again, to frames that perception may be chosen by and to rendered rooms.

    Attributes:
        bias: when all of ``TERMS`` are 0.
        weights: of ``TERMS``.
    """

    bias: float = rejoin_weights.BIAS
    weights: tuple[float, ...] = (
        rejoin_weights.MISFIT,
        rejoin_weights.BREADTH,
        rejoin_weights.TOP,
        rejoin_weights.OPEN_WAY,
        rejoin_weights.CHROMA,
    )

    def log_odds(self, features: PieceFeatures) -> float:
        """Above 0 they are rather one."""
        return self.bias + sum(w * value for w, value in zip(self.weights, model_row(features), strict=True))


def rejoined(pieces: Pieces, config: RejoinConfig) -> NDArray[np.int32]:
    """(count + 1,) group of each region after pieces of one thing have been joined, the surest pair first."""
    groups = pieces.groups.copy()
    scored = []
    for a, b in pieces.candidates():
        # A better fit speaks for one thing, so that most pairs are decided without it.
        outlines = pieces.compare_outlines(a, b)
        if config.weights[0] > 0 or config.log_odds(outlines) > 0.0:
            scored.append((config.log_odds(replace(outlines, misfit=pieces.misfit(a, b))), a, b))
    for odds, a, b in sorted(scored, reverse=True):
        if odds <= 0.0:
            break
        first, second = sorted((int(groups[a]), int(groups[b])))
        groups[groups == second] = first
    return groups


def _nearest(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The two points, one of each set, that are nearest to each other."""
    a, b = divmod(int(_squared_distances(one, other).argmin()), len(other))
    return one[a], other[b]


def _squared_distances(one: NDArray[np.float64], other: NDArray[np.float64]) -> FloatImage:
    """(n, m) squared distances of points."""
    # Pixels are integers: the sums are exact, in single precision too.
    first, second = one.astype(np.float32), other.astype(np.float32)
    squared = np.asarray((np.float32(-2.0) * first) @ second.T, dtype=np.float32)
    squared += np.einsum("ij,ij->i", second, second)
    squared += np.einsum("ij,ij->i", first, first)[:, None]
    return squared
