"""Two pieces on both sides of what stands before them: how much speaks for one object behind it.

A thing cut in two by an occluder goes on behind it: its face is the same plane, or the same lying cylinder, on both
sides; it is as wide; and between the pieces nothing is seen but the occluder and its shadow, least of all the table.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.segmentation.borders import Borders, PairTable, Relief
from mbd_perception.segmentation.joining import rejoin_weights
from mbd_perception.segmentation.regions import Regions

# About how many pixels of a region are looked at.
SAMPLE = 120
# A face of fewer pixels says nothing about how it goes on.
SMALLEST = 12
# At least this share of the way between them lies behind something, and at most this share shows the table.
HIDDEN, TABLE = 0.75, 0.2
# What is narrower than this share of both together is a shadow at a silhouette: two things that all but touch.
NARROW = 0.1
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
        for place, first in enumerate(numbers):
            for second in numbers[place + 1 :]:
                start, end = self._ends(first, second)
                hidden, table = self._between(start, end)
                if hidden >= HIDDEN and table <= TABLE and NARROW <= self._gap(first, second) <= WIDE:
                    found.append((first, second))
        return found

    def compare(self, first: int, second: int) -> PieceFeatures:
        """The features of two pieces."""
        one, other = self._coordinates(first), self._coordinates(second)
        start, end = self._ends(first, second)
        hidden, table = self._between(start, end)
        along = (other.mean(axis=0) - one.mean(axis=0)).astype(np.float64)
        along /= max(float(np.linalg.norm(along)), 1e-9)
        across = np.array([-along[1], along[0]])
        a, b = np.quantile(one @ across, [0.05, 0.95]), np.quantile(other @ across, [0.05, 0.95])
        shared = max(min(a[1], b[1]) - max(a[0], b[0]), 0.0)
        colors = [
            np.average(self._colors[m], axis=0, weights=self._area[m] + 1e-9) for m in map(self._of, (first, second))
        ]
        tops = [float(self._tops[self._of(g)].max()) for g in (first, second)]
        areas = sorted(float(self._area[self._of(g)].sum()) for g in (first, second))
        return PieceFeatures(
            misfit=self._misfit(first, second, along),
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

    def _gap(self, first: int, second: int) -> float:
        """Shortest way between two pieces over the length of both together, from middle to middle."""
        one, other = self._coordinates(first), self._coordinates(second)
        start, end = self._ends(first, second)
        along = other.mean(axis=0) - one.mean(axis=0)
        along /= max(float(np.linalg.norm(along)), 1e-9)
        reach = np.concatenate([one @ along, other @ along])
        return float(np.linalg.norm(end - start)) / max(float(np.ptp(reach)), 1.0)

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

    def _between(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> tuple[float, float]:
        """(share of the straight way on which something nearer or a shadow is seen, share on which the table is)."""
        steps = max(int(np.linalg.norm(end - start)), 2)
        share = np.linspace(0.0, 1.0, steps + 1)[1:-1]
        way = np.rint(start + share[:, None] * (end - start)).astype(int)
        w = self._relief.w
        ends = [float(w[int(p[1]), int(p[0])]) for p in (start, end)]
        seen = w[way[:, 1], way[:, 0]]
        nearer = seen > ends[0] + share * (ends[1] - ends[0]) + self._step
        table = self._relief.table[way[:, 1], way[:, 0]]
        shadow = (seen <= 0) | ((self.picture[way[:, 1], way[:, 0]] == 0) & ~table)
        return float((nearer | shadow).mean()), float(table.mean())

    def _misfit(self, first: int, second: int, along: NDArray[np.float64]) -> float:
        """Log of the error of one face through the best two faces, over the noise and the faces' own unevenness."""
        best = np.inf
        smaller = min(float(self._area[self._of(g)].sum()) for g in (first, second))
        for a in self._of(first):
            for b in self._of(second):
                if min(self._area[a], self._area[b]) < max(SMALLEST, 0.2 * smaller):
                    continue
                best = min(best, self._joint_error(int(a), int(b), along))
        return float(np.clip(np.log(best), -1.0, 5.0))

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
        root = np.sqrt(weight)[:, None]
        errors = [np.inf, np.inf]
        for _ in range(2):
            fit, *_ = np.linalg.lstsq(terms * root, w * root[:, 0], rcond=None)
            error = np.abs(terms @ fit - w)
            errors = [float(np.median(error[: len(one)])), float(np.median(error[len(one) :]))]
            root = root / np.sqrt(1.0 + (error / max(3.0 * self._noise, 2.0 * max(errors))) ** 2)[:, None]
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
    scored = [(config.log_odds(pieces.compare(a, b)), a, b) for a, b in pieces.candidates()]
    for odds, a, b in sorted(scored, reverse=True):
        if odds <= 0.0:
            break
        first, second = sorted((int(groups[a]), int(groups[b])))
        groups[groups == second] = first
    return groups


def _nearest(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The two points, one of each set, that are nearest to each other."""
    # Pixels are integers: the sums are exact.
    squared = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)[None] - 2.0 * (one @ other.T)
    a, b = np.unravel_index(int(squared.argmin()), squared.shape)
    return one[a], other[b]
