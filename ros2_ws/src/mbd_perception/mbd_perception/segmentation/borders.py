"""What lies between the regions of a picture: how long their borders are, how sharply they bend, who hides whom."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import ColorImage, FloatImage
from mbd_perception.segmentation.regions import SQUARE, Regions, RegionSamples

PairTable = NDArray[np.float64]
# One step of a bridge over pixels without depth [px].
BRIDGE_STEP = 2
# A region of fewer pixels is neither hollow nor bulging.
LEAST = 40
# Stronger bends count as this much, so that a few mixed pixels do not outweigh a border.
STRONGEST = 2.0


@dataclass(frozen=True)
class Relief:
    """What a depth picture states about shape.

    Attributes:
        w: (height, width) float32 inverse depth [1/m], 0 = none; not smoothed.
        bend: (height, width) float32 concavity.
        heights: (height, width) float32 above the table [m].
        table: (height, width) bool; pixels with depth that do not rise above the table.
        focal: focal length [px] of this picture.
    """

    w: FloatImage
    bend: FloatImage
    heights: FloatImage
    table: NDArray[np.bool_]
    focal: float


@dataclass(frozen=True)
class Borders:
    """Borders between regions, in pixel pairs; (n + 1, n + 1) tables, index 0 is everything that is no region.

    Attributes:
        length: pairs of neighbouring pixels; symmetric.
        crease: those of them that lie on a crease; symmetric.
        bend: mean concavity along the border, each pixel at most ``STRONGEST``; symmetric.
        jump: [a, b] pairs where a is nearer than b by a jump.
    """

    length: PairTable
    crease: PairTable
    bend: PairTable
    jump: PairTable


def find_borders(regions: Regions, relief: Relief, crease: FloatImage, step: FloatImage, gap: int) -> Borders:
    """Measure the borders of regions.

    Args:
        regions: the regions.
        relief: the picture they are in.
        crease: (height, width) float32; where the bend exceeds it there is a crease.
        step: (height, width) float32; a larger difference of inverse depth is a jump [1/m].
        gap: pixels that are neither region nor table are bridged up to this far [px]: the shadows that a projector
            leaves at silhouettes.
    """
    w, bend = relief.w, relief.bend
    wide = cv2.dilate(np.minimum(bend, np.float32(STRONGEST)), SQUARE)
    on_crease = wide > crease
    filled, value = regions.labels, w
    kernel = np.ones((2 * BRIDGE_STEP + 1,) * 2, dtype=np.uint8)
    for _ in range(gap // BRIDGE_STEP):
        take = (filled == 0) & ~relief.table
        grown, near = cv2.dilate(filled, kernel), cv2.dilate(value, kernel)
        filled, value = np.where(take, grown, filled), np.where(take & (grown > 0), near, value)
    size = regions.count + 1
    width = w.shape[1]
    beside, below = np.zeros(filled.shape, dtype=bool), np.zeros(filled.shape, dtype=bool)
    np.not_equal(filled[:, :-1], filled[:, 1:], out=beside[:, :-1])
    np.not_equal(filled[:-1], filled[1:], out=below[:-1])
    first, second = np.flatnonzero(beside), np.flatnonzero(below)
    at, other = np.concatenate([first, second]), np.concatenate([first + 1, second + width])
    numbers, nearness, limit = filled.ravel(), value.ravel(), step.ravel()[at]
    key = numbers[at].astype(np.intp) * size + numbers[other]
    difference = nearness[at] - nearness[other]
    hollow = on_crease.ravel()[at] | on_crease.ravel()[other]
    depth = np.maximum(wide.ravel()[at], wide.ravel()[other])

    def summed(weights: NDArray[np.generic] | None = None) -> PairTable:
        return np.bincount(key, weights=weights, minlength=size * size).reshape(size, size).astype(np.float64)

    length, creased, bent = (table + table.T for table in (summed(), summed(hollow), summed(depth)))
    jump = summed(difference > limit) + summed(-difference > limit).T
    bent /= np.maximum(length, 1)
    return Borders(length, creased, bent, jump)


def hollowness(regions: Regions, relief: Relief, borders: Borders) -> NDArray[np.float64]:
    """How hollow each region is: its depth in the middle over its width, from a quadratic fit of inverse depth.

    A half pipe seen from inside has 0.5, a flat face 0, what bends towards the viewer less than 0.

    Returns:
        (count + 1,) along the direction in which each region bends most; 0 for one that touches no other.
    """
    sags = np.zeros(regions.count + 1)
    touching = borders.length[:, 1:].sum(axis=1) > 0
    values, width = relief.w.ravel(), relief.w.shape[1]
    some = regions.samples
    some = some.where(touching[some.region] & (values[some.pixels] > 0))
    some = some.where((some.sizes >= LEAST)[some.region])
    if len(some.pixels) == 0:
        return sags
    v, u = (c.astype(np.float64) for c in np.divmod(some.pixels, width))
    value = values[some.pixels].astype(np.float64)
    size = np.maximum(some.sizes, 1)
    du, dv = ((c - (some.sums(c) / size)[some.region]) for c in (u, v))
    terms = np.stack([np.ones(len(u)), du, dv, 0.5 * du * du, du * dv, 0.5 * dv * dv], axis=1)
    error = np.abs((terms * _fits(some, terms, value)[some.region]).sum(axis=1) - value)
    # Pixels that mix two surfaces at the silhouette lie far off: fit again without the worst tenth.
    kept = error <= some.quantiles(error, 0.9)[some.region]
    fits = _fits(some.where(kept), terms[kept], value[kept])
    bends, axes = np.linalg.eigh(fits[:, [3, 4, 4, 5]].reshape(-1, 2, 2))
    most = np.abs(bends).argmax(axis=1)
    every = np.arange(len(fits))
    # Extent in that direction: the width of a uniform strip of the same std.
    along = du * axes[every, 0, most][some.region] + dv * axes[every, 1, most][some.region]
    widths = np.sqrt(12 * some.sums(along * along) / size)
    fitted = some.sizes > 0
    mean = some.sums(value) / size
    sags[fitted] = (0.125 * bends[every, most] * widths * relief.focal)[fitted] / mean[fitted]
    return sags


def _fits(some: RegionSamples, terms: PairTable, value: NDArray[np.float64]) -> PairTable:
    """(count + 1, k) least squares of (n,) values by (n, k) terms in each region.

    A little regularised, so that a region one pixel wide is flat rather than undetermined; 0 for one without pixels.
    """
    both = np.column_stack([terms, value])
    products = np.zeros((some.count + 1, both.shape[1], both.shape[1]))
    for number, part in some.parts:
        products[number] = both[part].T @ both[part]
    scale, moments = products[:, :-1, :-1], products[:, :-1, -1:]
    diagonal = np.arange(terms.shape[1])
    scale[:, diagonal, diagonal] *= 1 + 1e-9
    scale[:, diagonal, diagonal] += 1e-9
    return np.asarray(np.linalg.solve(scale, moments)[..., 0])


def region_tops(regions: Regions, relief: Relief) -> NDArray[np.float64]:
    """(count + 1,) height above the table [m] that a twentieth of each region exceeds."""
    some = regions.samples
    return some.quantiles(relief.heights.ravel()[some.pixels], 0.95)


def region_colors(regions: Regions, color: ColorImage) -> NDArray[np.float64]:
    """(count + 1, 3) mean CIE L a b (8-bit scale) of each region."""
    some = regions.samples
    if len(some.pixels) == 0:
        return np.zeros((regions.count + 1, 3))
    v, u = np.divmod(some.pixels, color.shape[1])
    lab = cv2.cvtColor(color[v, u][None], cv2.COLOR_RGB2Lab)[0].astype(np.float64)
    return np.stack([some.sums(channel) for channel in lab.T], axis=1) / np.maximum(some.sizes, 1)[:, None]
