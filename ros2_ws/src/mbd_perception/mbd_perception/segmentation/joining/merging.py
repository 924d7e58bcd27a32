"""Which regions are one object.

Two convex regions that meet in a crease are two objects, unless the crease is weak and their colour the same. A crumb
is part of its neighbour. A hollow is no object: it is the inside of what stands before it or around it, with a rim of
the same height.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_perception.segmentation.borders import Borders, PairTable
from mbd_perception.segmentation.regions import Regions


@dataclass(frozen=True)
class MergeConfig:
    """When two regions are one object.

    Attributes:
        crease_share: a border separates when at least this share of it lies on a crease.
        sharp: mean concavity (change of slope) above which a crease separates whatever the colours: 45 degrees.
        same_chroma, same_lightness: difference of CIE a b, and of L (8-bit scale), up to which colours are the same;
            chroma differs by half of this within one plain thing, lightness much more, by shading.
        crumb: a region smaller than this share of a neighbour is part of it, whatever its colour (a lip, print).
        crumb_alike: the same for one of the same colour (a handle).
        crumb_flush: the same for one that, along their border, hides nothing and is hidden nowhere (a lid, a strip
            above an occluder): what stands on or before another thing hides a part of it.
        flush: share of the border that may be a jump all the same.
        hollow: a region is a hollow when its depth is more than this share of its width: 0.5 is a half pipe, 0.1 an
            arc of 45 degrees.
        convex: a region less hollow than this, and not as high as the rim, is no part of a hollow: a ball in a bowl.
        rim_share: a hollow belongs to what hides its foot along at least this share of its outline.
        rim_height: front and back of a rim are equally high up to this share of the height.
        enclosed_share: a region hidden on all sides along this share of its outline lies inside what hides it.
        embedded_share: a region that hides nothing, along this share of its outline, is part of what surrounds it.
    """

    crease_share: float = 0.5
    sharp: float = 1.0
    same_chroma: float = 12.0
    same_lightness: float = 60.0
    crumb: float = 0.04
    crumb_alike: float = 0.12
    crumb_flush: float = 0.15
    flush: float = 0.1
    hollow: float = 0.1
    convex: float = -0.1
    rim_share: float = 0.03
    rim_height: float = 0.2
    enclosed_share: float = 0.8
    embedded_share: float = 0.5


@dataclass(frozen=True)
class RegionTraits:
    """What regions are like; (n + 1,) or (n + 1, 3), index 0 unused.

    Attributes:
        hollow: hollowness.
        tops: height of the top above the table [m].
        colors: mean CIE L a b, 8-bit scale.
    """

    hollow: NDArray[np.float64]
    tops: NDArray[np.float64]
    colors: PairTable


class RegionMerger:
    """Joins regions into objects, rule by rule.

    Attributes:
        groups: (n + 1,) the smallest region number of the same object; 0 for 0.
    """

    def __init__(self, regions: Regions, borders: Borders, traits: RegionTraits, config: MergeConfig) -> None:
        self._borders, self._traits, self._config = borders, traits, config
        self.groups = np.arange(regions.count + 1, dtype=np.int32)
        self._numbers = range(1, regions.count + 1)
        self._area = np.bincount(regions.labels.ravel(), minlength=regions.count + 1).astype(np.float64)
        self._outline = np.maximum(borders.length.sum(axis=1), 1)
        touching = borders.length > 0
        touching[0] = touching[:, 0] = False
        self._on_surface = touching & (regions.surface[:, None] == regions.surface[None])
        self._touching = touching
        self._surface = regions.surface
        chroma = np.linalg.norm(traits.colors[:, None, 1:] - traits.colors[None, :, 1:], axis=2)
        lightness = np.abs(traits.colors[:, None, 0] - traits.colors[None, :, 0])
        higher = np.maximum(traits.tops[:, None], traits.tops[None])
        self._as_high = np.abs(traits.tops[:, None] - traits.tops[None]) <= config.rim_height * higher
        self._alike = (chroma < config.same_chroma) & (lightness < config.same_lightness)

    def join_over_weak_borders(self) -> None:
        """Join over borders that are no crease, weak creases in one colour, and creases within a hollow."""
        config, borders, hollow = self._config, self._borders, self._traits.hollow
        smooth = borders.crease < config.crease_share * borders.length
        weak = self._alike & (borders.bend < config.sharp)
        one_vessel = self._as_high | (hollow > config.convex)[None]
        inside = (hollow > config.hollow)[:, None] & one_vessel
        for i, j in np.argwhere(self._on_surface & (smooth | weak | inside | inside.T)):
            self._join(int(i), int(j))

    def join_severed(self) -> None:
        """Join a region that does not touch the rest of its surface to the largest part of it: no crease cut it off."""
        for i in self._numbers:
            same = self._surface == self._surface[i]
            if same.sum() > 1 and not self._on_surface[i].any():
                self._join(i, int(np.where(same, self._area, 0).argmax()))

    def join_crumbs(self) -> None:
        """Join what is small to the neighbour it borders longest, unless a jump lies between them.

        On its own surface first; across surfaces, where a shadow came between, along a third of its outline.
        """
        length, config = self._borders.length, self._config
        jumps = self._borders.jump + self._borders.jump.T
        no_jump = jumps < 0.5 * length
        for i in self._numbers:
            own = np.where(self._on_surface[i] & no_jump[i], length[i], 0)
            across = np.where(self._touching[i] & no_jump[i] & (length[i] >= self._outline[i] / 3), length[i], 0)
            flush = np.where(jumps[i] < config.flush * length[i], own, 0)
            rules = (
                (own, config.crumb_alike, self._alike[i]),
                (flush, config.crumb_flush, None),
                (own, config.crumb, None),
                (across, config.crumb, None),
            )
            for along, limit, where in rules:
                j = int(along.argmax())
                enough = where is None or bool(where[j])
                if along[j] > 0 and enough and self._area[i] < limit * self._area[j]:
                    self._join(i, j)
                    break

    def join_hollows(self) -> None:
        """Join a hollow to what hides its foot and is as high, and what is hidden on all sides to what hides it."""
        config, traits = self._config, self._traits
        creases = np.where(self._on_surface, self._borders.crease, 0)
        for hollow in np.unique(self.groups[1:]):
            inside = self.groups == hollow
            if not inside.any():  # joined to another meanwhile
                continue
            largest = int(np.where(inside, self._area, 0).argmax())
            length = self._by_group(self._borders.length, inside)
            outline = max(length.sum() - length[hollow], 1.0)
            jump = self._by_group(self._borders.jump.T, inside)
            bent = self._by_group(creases, inside)
            jump[0] = bent[0] = jump[hollow] = bent[hollow] = 0
            top = traits.tops[inside].max()
            tops = np.zeros(len(self.groups))
            np.maximum.at(tops, self.groups, traits.tops)
            rim = np.where(np.abs(tops - top) <= config.rim_height * np.maximum(tops, top), jump + bent, 0)
            if traits.hollow[largest] > config.hollow and rim.max() >= config.rim_share * outline:
                self._join(int(hollow), int(rim.argmax()))
            elif jump.max() >= config.enclosed_share * outline:
                self._join(int(hollow), int(jump.argmax()))

    def _by_group(self, table: PairTable, inside: NDArray[np.bool_]) -> NDArray[np.float64]:
        """(n + 1,) sum of a table's rows of some regions, its columns summed by group; index is the group's number."""
        sums = np.bincount(self.groups, weights=table[inside].sum(axis=0), minlength=len(self.groups))
        return np.asarray(sums, dtype=np.float64)

    def join_embedded(self) -> None:
        """Join a region that lies in the surface of a group of the same colour and hides nothing of it."""
        joinable, tops = self._on_surface & self._alike, self._traits.tops
        for i in self._numbers:
            if (self.groups == self.groups[i]).sum() > 1:
                continue
            for group in np.unique(self.groups[joinable[i]]):
                members = self.groups == group
                shared = self._borders.length[i, members].sum()
                hiding = self._borders.jump[i, members].sum()
                # What rises out of the group stands on it.
                lower = tops[i] <= (1 + self._config.rim_height) * tops[members].max()
                if lower and shared >= self._config.embedded_share * self._outline[i] and hiding < 0.1 * shared:
                    self._join(i, int(group))
                    break

    def _join(self, i: int, j: int) -> None:
        """Make the groups of two regions one."""
        first, second = sorted((self.groups[i], self.groups[j]))
        self.groups[self.groups == second] = first


def merge_regions(regions: Regions, borders: Borders, traits: RegionTraits, config: MergeConfig) -> NDArray[np.int32]:
    """Which object each region belongs to.

    Returns:
        (count + 1,) the smallest region number of the same object; 0 for 0.
    """
    merger = RegionMerger(regions, borders, traits, config)
    if regions.count > 1:
        merger.join_severed()
        merger.join_over_weak_borders()
        merger.join_crumbs()
        merger.join_hollows()
        merger.join_embedded()
    return merger.groups
