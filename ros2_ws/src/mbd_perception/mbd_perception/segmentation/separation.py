"""From surfaces to objects: cut at creases, put together what belongs together."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.segmentation.borders import Relief, find_borders, hollowness, region_colors, region_tops
from mbd_perception.segmentation.components import JumpConfig, Labels, Mask, renumbered
from mbd_perception.segmentation.concavity import concavity, inverse_depth, smoothed
from mbd_perception.segmentation.joining.merging import MergeConfig, RegionTraits, merge_regions
from mbd_perception.segmentation.joining.occlusion import Pieces
from mbd_perception.segmentation.joining.rejoining import RejoinConfig, rejoined
from mbd_perception.segmentation.regions import Regions, cut_regions, grow


@dataclass(frozen=True)
class SeparationConfig:
    """How touching objects are separated. Lengths are pixels of the picture at half size.

    Attributes:
        reach: half the distance over which a bend is measured: about 1 cm on the table of a 640 px camera at 0.7 m.
        min_bend: smallest change of slope that is a crease: faces that meet at about 30 degrees.
        bend_sigmas: that many std of noise are no crease either.
        smoothing: by how much the medians reduce the noise of inverse depth.
        min_core: smallest region.
        gap: shadows at silhouettes are bridged up to this far: focal x baseline x depth of a hollow / distance squared.
        merge: when two regions are one object.
        rejoin: when two pieces behind an occluder are one object.
    """

    reach: int = 4
    min_bend: float = 0.5
    bend_sigmas: float = 3.0
    smoothing: float = 3.0
    min_core: int = 20
    gap: int = 6
    merge: MergeConfig = field(default_factory=MergeConfig)
    rejoin: RejoinConfig = field(default_factory=RejoinConfig)


@dataclass(frozen=True)
class Separation:
    """Surfaces taken apart.

    Attributes:
        objects: (height, width) int32, 0 = none; numbers are not contiguous.
        bend: (height / 2, width / 2) float32 concavity.
        regions: what the surfaces were cut into, at half size.
        pieces: what they were merged into, before pieces on both sides of an occluder were joined; None when too few.
    """

    objects: Labels
    bend: FloatImage
    regions: Regions
    pieces: Pieces | None


def separate(
    frame: RgbdFrame,
    surfaces: Labels,
    heights: FloatImage,
    table: Mask,
    *,
    noise: float,
    jump: JumpConfig,
    config: SeparationConfig,
) -> Separation:
    """Objects from surfaces.

    Args:
        frame: what the camera saw.
        surfaces: (height, width) int32, 0 = none.
        heights: (height, width) float32 above the table [m].
        table: (height, width) bool; pixels with depth that do not rise above the table.
        noise: std of inverse depth [1/m] in this frame.
        jump: when neighbours are apart.
        config: thresholds.
    """
    small = surfaces[::2, ::2].astype(np.uint16)
    focal = frame.camera.fx / 2
    w = inverse_depth(np.ascontiguousarray(frame.depth[::2, ::2]))
    bend = concavity(smoothed(w), small, focal, config.reach)
    relief = Relief(w, bend, heights[::2, ::2], table[::2, ::2], focal)
    slope_noise = np.float32(config.bend_sigmas * 2.4 * noise / config.smoothing * focal / config.reach)
    crease = np.maximum(np.float32(config.min_bend), slope_noise / np.maximum(w, np.float32(0.05)))
    regions = cut_regions(small, bend > crease, config.reach, config.min_core)
    step = np.float32(np.tan(jump.grazing) / focal) * w + np.float32(jump.sigmas * noise)
    borders = find_borders(regions, relief, crease, step, config.gap)
    colors = region_colors(regions, frame.color[::2, ::2])
    traits = RegionTraits(hollowness(regions, relief, borders), region_tops(regions, relief), colors)
    groups = merge_regions(regions, borders, traits, config.merge)
    pieces = None
    if len(np.unique(groups)) > 3:  # nothing, an occluder and two pieces behind it
        pieces = Pieces(regions, borders, relief, groups=groups, colors=colors, tops=traits.tops, noise=noise)
        groups = rejoined(pieces, config.rejoin)
    return Separation(_full_size(surfaces, regions, groups), bend, regions, pieces)


def _full_size(surfaces: Labels, regions: Regions, groups: NDArray[np.int32]) -> Labels:
    """Object numbers at full size from regions at half size; surfaces of one object keep their own outline."""
    first, last = (np.zeros(int(surfaces.max()) + 1, dtype=np.int32) for _ in range(2))
    # A surface too thin to be seen at half size is an object of its own.
    first[:] = last[:] = len(groups) + np.arange(len(first))
    order = np.argsort(groups[1:], kind="stable") + 1
    last[regions.surface[order]] = groups[order]
    first[regions.surface[order[::-1]]] = groups[order[::-1]]
    first[0] = last[0] = 0
    objects = renumbered(surfaces, first)
    mixed = first != last
    if not mixed.any():
        return objects
    height, width = surfaces.shape
    shared = renumbered(surfaces, mixed) > 0
    large = np.repeat(np.repeat(regions.labels, 2, axis=0), 2, axis=1)[:height, :width]
    large = np.where(shared & (regions.surface.take(large) == surfaces), large, 0).astype(np.uint16)
    large = grow(large, np.where(shared, surfaces, 0), regions.surface, 3)
    return np.where(shared, groups.take(large), objects)
