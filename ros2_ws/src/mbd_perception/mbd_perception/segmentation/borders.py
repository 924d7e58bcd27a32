"""What lies between the regions of a picture: how long their borders are, how sharply they bend, who hides whom."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import ColorImage, FloatImage
from mbd_perception.quantile import quantile
from mbd_perception.segmentation.regions import SQUARE, Regions

PairTable = NDArray[np.float64]
# One step of a bridge over pixels without depth [px].
BRIDGE_STEP = 2
# About how many pixels of a region are looked at for its traits.
SAMPLE = 200
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
    length, creased, bent, jump = (np.zeros(size * size) for _ in range(4))
    everything = slice(None)
    for first, second in (
        ((everything, slice(None, -1)), (everything, slice(1, None))),
        ((slice(None, -1), everything), (slice(1, None), everything)),
    ):
        at = np.nonzero(filled[first] != filled[second])
        i, j = filled[first][at].astype(np.int64), filled[second][at].astype(np.int64)
        difference = value[first][at] - value[second][at]
        limit = step[first][at]
        hollow = on_crease[first][at] | on_crease[second][at]
        depth = np.maximum(wide[first][at], wide[second][at])
        for a, b, nearer in ((i, j, difference > limit), (j, i, -difference > limit)):
            key = a * size + b
            length += np.bincount(key, minlength=size * size)
            creased += np.bincount(key, weights=hollow, minlength=size * size)
            bent += np.bincount(key, weights=depth, minlength=size * size)
            jump += np.bincount(key, weights=nearer, minlength=size * size)
    bent /= np.maximum(length, 1)
    shape = (size, size)
    return Borders(length.reshape(shape), creased.reshape(shape), bent.reshape(shape), jump.reshape(shape))


def hollowness(regions: Regions, relief: Relief, borders: Borders) -> NDArray[np.float64]:
    """How hollow each region is: its depth in the middle over its width, from a quadratic fit of inverse depth.

    A half pipe seen from inside has 0.5, a flat face 0, what bends towards the viewer less than 0.

    Returns:
        (count + 1,) along the direction in which each region bends most; 0 for one that touches no other.
    """
    sags = np.zeros(regions.count + 1)
    touching = borders.length[:, 1:].sum(axis=1) > 0
    values = relief.w.ravel()
    for number, region in enumerate(regions.pixels, start=1):
        if not touching[number]:
            continue
        pixels = region[:: max(1, len(region) // SAMPLE)]
        pixels = pixels[values[pixels] > 0]
        if len(pixels) < 40:
            continue
        v, u = np.divmod(pixels, relief.w.shape[1])
        value = values[pixels].astype(np.float64)
        du, dv = u - u.mean(), v - v.mean()
        terms = np.stack([np.ones(len(u)), du, dv, 0.5 * du * du, du * dv, 0.5 * dv * dv])
        error = np.abs(_fit(terms, value) @ terms - value)
        # Pixels that mix two surfaces at the silhouette lie far off: fit again without the worst tenth.
        kept = error <= quantile(error, 0.9)
        fit = _fit(terms[:, kept], value[kept])
        bends, axes = np.linalg.eigh(np.array([[fit[3], fit[4]], [fit[4], fit[5]]]))
        most = int(np.argmax(np.abs(bends)))
        # Extent in that direction: the width of a uniform strip of the same std.
        along = du * axes[0, most] + dv * axes[1, most]
        width = np.sqrt(12 * float(along @ along) / len(along))
        sags[number] = 0.125 * bends[most] * width * relief.focal / float(value.mean())
    return sags


def _fit(terms: PairTable, value: PairTable) -> PairTable:
    """Least squares; a little regularised, so that a region one pixel wide is flat rather than undetermined."""
    scale = terms @ terms.T
    scale[np.diag_indices(len(scale))] *= 1 + 1e-9
    scale[np.diag_indices(len(scale))] += 1e-9
    return np.asarray(np.linalg.solve(scale, terms @ value))


def region_tops(regions: Regions, relief: Relief) -> NDArray[np.float64]:
    """(count + 1,) height above the table [m] that a twentieth of each region exceeds."""
    tops = np.zeros(regions.count + 1)
    heights = relief.heights.ravel()
    for number, region in enumerate(regions.pixels, start=1):
        if len(region):
            tops[number] = quantile(heights[region[:: max(1, len(region) // SAMPLE)]], 0.95)
    return tops


def region_colors(regions: Regions, color: ColorImage) -> NDArray[np.float64]:
    """(count + 1, 3) mean CIE L a b (8-bit scale) of each region."""
    mean = np.zeros((regions.count + 1, 3))
    samples = [region[:: max(1, len(region) // SAMPLE)] for region in regions.pixels]
    if not samples:
        return mean
    v, u = np.divmod(np.concatenate(samples), color.shape[1])
    lab = cv2.cvtColor(color[v, u][None], cv2.COLOR_RGB2Lab)[0].astype(np.float64)
    sizes = np.array([len(s) for s in samples])
    sums = np.add.reduceat(lab, np.cumsum(sizes) - sizes, axis=0)
    mean[1:] = sums / sizes[:, None]
    return mean
