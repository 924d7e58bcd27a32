"""Surfaces cut along their creases into regions that are convex, or hollow, but not both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.quantile import quantile
from mbd_perception.segmentation.components import Mask

# About how many pixels of a region are looked at for its traits.
SAMPLE = 200
SQUARE = np.ones((3, 3), dtype=np.uint8)


@dataclass(frozen=True)
class RegionSamples:
    """Some pixels of each region.

    Attributes:
        pixels: (n,) flat indices.
        region: (n,) region of each, rising.
        count: number of regions.
    """

    pixels: NDArray[np.intp]
    region: NDArray[np.intp]
    count: int

    @cached_property
    def sizes(self) -> NDArray[np.intp]:
        """(count + 1,) number of pixels."""
        return np.bincount(self.region, minlength=self.count + 1)

    @cached_property
    def parts(self) -> list[tuple[int, slice]]:
        """Every region that has pixels, and which they are."""
        ends = np.cumsum(self.sizes).tolist()
        return [(i, slice(ends[i - 1], ends[i])) for i in range(1, self.count + 1) if ends[i] > ends[i - 1]]

    def where(self, chosen: Mask) -> RegionSamples:
        """Those of them that are chosen, (n,) bool."""
        return RegionSamples(self.pixels[chosen], self.region[chosen], self.count)

    def sums(self, values: NDArray[np.floating]) -> NDArray[np.float64]:
        """(count + 1,) sums of (n,) values by region; 0 for a region without pixels."""
        return np.asarray(np.bincount(self.region, weights=values, minlength=self.count + 1), dtype=np.float64)

    def quantiles(self, values: NDArray[np.floating], share: float) -> NDArray[np.float64]:
        """(count + 1,) value below which that share of (n,) values lies, without interpolation; 0 for no pixels."""
        found = np.zeros(self.count + 1)
        for number, part in self.parts:
            found[number] = quantile(values[part], share)
        return found


@dataclass(frozen=True)
class Regions:
    """A finer partition of surfaces.

    Attributes:
        labels: (height, width) uint16; 0 = none, 1..count.
        count: number of regions.
        surface: (count + 1,) surface that each region is part of; 0 for none.
    """

    labels: NDArray[np.uint16]
    count: int
    surface: NDArray[np.int32]

    @cached_property
    def pixels(self) -> list[NDArray[np.intp]]:
        """Flat indices of the pixels of each region, region 1 first."""
        flat = self.labels.ravel()
        covered = np.flatnonzero(flat > 0)
        label = flat[covered]
        order = covered[np.argsort(label, kind="stable")]
        ends = np.cumsum(np.bincount(label, minlength=self.count + 1))
        return [order[ends[i - 1] : ends[i]] for i in range(1, self.count + 1)]

    @cached_property
    def samples(self) -> RegionSamples:
        """About ``SAMPLE`` pixels of each region, spread evenly over it."""
        some = [region[:: max(1, len(region) // SAMPLE)] for region in self.pixels]
        sizes = np.array([len(s) for s in some], dtype=np.intp)
        pixels = np.concatenate(some) if some else np.zeros(0, dtype=np.intp)
        return RegionSamples(pixels, np.repeat(np.arange(1, self.count + 1), sizes), self.count)


def cut_regions(surfaces: NDArray[np.integer], crease: Mask, reach: int, min_core: int) -> Regions:
    """Cut surfaces where creases close a line, up to gaps of two pixels.

    What lies off the creases, thinned by a pixel, falls apart into cores; each core grows back over the crease until it
    meets its neighbour, which is in the middle of the crease. A surface that is all crease is one region.

    Args:
        surfaces: (height, width) labels, 0 = none.
        crease: (height, width) bool.
        reach: half width of a crease [px].
        min_core: smallest core [px].
    """
    wide = cv2.dilate(crease.astype(np.uint8), SQUARE)
    core = ((surfaces > 0) & (wide == 0)).astype(np.uint8)
    # Cores of different surfaces must not touch.
    core[:, 1:] &= (surfaces[:, 1:] == surfaces[:, :-1]).view(np.uint8)
    core[1:] &= (surfaces[1:] == surfaces[:-1]).view(np.uint8)
    _, cores, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=4, ltype=cv2.CV_32S)
    large = stats[:, cv2.CC_STAT_AREA] >= min_core
    large[0] = False
    numbers = np.where(large, np.cumsum(large), 0).astype(np.uint16)
    labels = np.asarray(numbers.take(cores), dtype=np.uint16)
    surface = np.zeros(int(large.sum()) + 1, dtype=np.int32)
    for place, number in enumerate(np.flatnonzero(large).tolist(), start=1):
        left, top, width = stats[number, :3].tolist()
        surface[place] = surfaces[top, left + int((cores[top, left : left + width] == number).argmax())]
    last = int(surfaces.max())
    uncut = np.ones(last + 1, dtype=bool)
    uncut[surface] = uncut[0] = False
    if uncut.any():
        uncut &= np.bincount(surfaces.ravel(), minlength=last + 1) > 0
    without = np.flatnonzero(uncut)
    if len(without):
        extra = np.zeros(last + 1, dtype=np.uint16)
        extra[without] = len(surface) + np.arange(len(without))
        labels = np.where(labels == 0, extra[surfaces], labels).astype(np.uint16)
        surface = np.concatenate([surface, without]).astype(np.int32)
    return Regions(grow(labels, surfaces, surface, 3 * reach), len(surface) - 1, surface)


def grow(
    labels: NDArray[np.uint16], surfaces: NDArray[np.integer], surface: NDArray[np.int32], steps: int
) -> NDArray[np.uint16]:
    """Grow regions over the unlabelled pixels of their own surface, one pixel a step.

    Args:
        labels: (height, width) regions, 0 = none.
        surfaces: (height, width) surfaces, 0 = none.
        surface: (count + 1,) surface of each region.
        steps: how many pixels at most.
    """
    grown = labels.copy()
    flat, own = grown.ravel(), surfaces.ravel()
    free = np.flatnonzero((flat == 0) & (own > 0))
    for _ in range(steps):
        if len(free) == 0:
            break
        near = cv2.dilate(grown, SQUARE).ravel()[free]
        take = (near > 0) & (surface[near] == own[free])
        if not take.any():
            break
        flat[free[take]] = near[take]
        free = free[~take]
    return grown
