"""E: how alike source object i and target object j are by feature k (paper sec. 4.3.1, eq. 2).

E has shape (7, n, m), features in the order of ``mbd_model.estimate.Feature``. Its two shift layers depend on the
assists and are recomputed after each; every other layer is computed once.

A missing hue (config.MissingHue.GREY): in the hue-saturation plane grey is the centre of the circle of hues. Two
greys are in the same place, so their similarity is 1; grey is equally far from every hue, and so can favour none: it
counts as a quarter turn (90 deg) away from each. Turning the circle (hue shift) leaves its centre where it is, so the
same holds for the shift. An assist with a grey object states nothing about the shift.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.tables import Floats, ObjectTable

HUE, HUE_SHIFT, SIZE, SIZE_SHIFT, SPATIAL, AFFORDANCE, PROPERTY = range(7)
NUM_FEATURES = 7
HUE_RANGE = 360.0
GREY_DISTANCE = 90.0
BALANCED = 1e-9  # mean resultant length below which angles have no mean direction
RECORDED_MISSING_HUE = -1000.0


def similarity(difference: Floats, spread: float | Floats, sigma: float) -> Floats:
    """D(v1, v2, r) of eq. 2 from ``difference`` = v2 - v1 and ``spread`` = r: exp(-difference^2 / 2 (sigma r)^2)."""
    return np.exp(-0.5 * (difference / (sigma * spread)) ** 2)


def hue_difference(a: Floats, b: Floats) -> Floats:
    """Circular a - b [deg], in [-180, 180]; NaN where either is."""
    turned = a - b
    whole: Floats = turned - 360.0 * np.rint(turned / 360.0)
    return whole


def circular_means(differences: Floats) -> Floats:
    """(S,) circular means [deg] of angles (S, k), those that are NaN left out; NaN where it does not exist.

    Angles that balance (0, 120 and 240 deg) have no mean: what atan2 makes of their sum is rounding, which depends on
    the order they are added in.
    """
    angle = np.radians(differences)
    known = ~np.isnan(angle)
    angle = np.where(known, angle, 0.0)
    sine, cosine = (np.sin(angle) * known).sum(axis=1), (np.cos(angle) * known).sum(axis=1)
    balanced = np.hypot(sine, cosine) <= BALANCED * np.maximum(known.sum(axis=1), 1)
    return np.where(balanced, np.nan, np.degrees(np.arctan2(sine, cosine)))


def overlap_similarity(size: Floats, overlap: Floats, sigma: float) -> Floats:
    """D(|x_i|, |x_i and x_j|, |x_i|); ``size`` (n,), ``overlap`` (n, m). Rows of |x_i| = 0 are left at 0."""
    safe = np.where(size > 0, size, 1.0)[:, None]
    return np.where(size[:, None] > 0, similarity(overlap - size[:, None], safe, sigma), 0.0)


def multiset_similarity(source: Floats, target: Floats, sigma: float) -> Floats:
    """Spatial relations as multisets of kinds: counts (n, 4) and (m, 4) to (n, m)."""
    overlap = np.minimum(source[:, None, :], target[None, :, :]).sum(axis=2)
    size = source.sum(axis=1)
    both_empty = (size[:, None] == 0) & (target.sum(axis=1)[None, :] == 0)
    return np.where(both_empty, 1.0, overlap_similarity(size, overlap, sigma))


def set_similarity(source: Sequence[frozenset[str]], target: Sequence[frozenset[str]], sigma: float) -> Floats:
    """Affordances or properties: sets (n,) and (m,) to (n, m)."""
    place = {name: k for k, name in enumerate(sorted(frozenset().union(*source, *target)))}

    def membership(sets: Sequence[frozenset[str]]) -> Floats:
        table = np.zeros((len(sets), max(1, len(place))))
        for row, members in enumerate(sets):
            table[row, [place[name] for name in members]] = 1.0
        return table

    # For sets, as for multisets with counts 0 and 1, the smaller count is the product.
    a, b = membership(source), membership(target)
    size = a.sum(axis=1)
    both_empty = (size[:, None] == 0) & (b.sum(axis=1)[None, :] == 0)
    return np.where(both_empty, 1.0, overlap_similarity(size, a @ b.T, sigma))


@dataclass(frozen=True, eq=False)
class Comparison:
    """Source and target objects, compared.

    Attributes:
        source, target: tables of n and m objects.
        config: sigma and what a missing hue counts as.
        fixed: (7, n, m), the layers that no assist changes; zeros in the shift layers.
        source_hue, target_hue: (n,), (m,) [deg] as compared.
    """

    source: ObjectTable
    target: ObjectTable
    config: MappingConfig
    fixed: Floats
    source_hue: Floats
    target_hue: Floats

    @staticmethod
    def of(source: ObjectTable, target: ObjectTable, config: MappingConfig) -> Comparison:
        """Compute every layer that no assist changes."""
        sigma = config.sigma
        source_hue, target_hue = source.hue, target.hue
        if config.missing_hue == MissingHue.AS_RECORDED:
            source_hue = np.where(np.isnan(source_hue), RECORDED_MISSING_HUE, source_hue)
            target_hue = np.where(np.isnan(target_hue), RECORDED_MISSING_HUE, target_hue)
        fixed = np.zeros((NUM_FEATURES, len(source), len(target)))
        if len(source) and len(target):
            ratio = target.volume[None, :] / source.volume[:, None]
            fixed[HUE] = _hue_layer(source_hue, target_hue, 0.0, sigma)
            fixed[SIZE] = similarity(ratio - 1.0, float(source.volume.max() / source.volume.min()), sigma)
            fixed[SPATIAL] = multiset_similarity(source.relations, target.relations, sigma)
            fixed[AFFORDANCE] = set_similarity(source.affordances, target.affordances, sigma)
            fixed[PROPERTY] = set_similarity(source.properties, target.properties, sigma)
        return Comparison(source, target, config, fixed, source_hue, target_hue)

    def shifts(self, pairs: Sequence[tuple[int, int]]) -> tuple[float | None, float | None]:
        """(mu_c [deg], mu_d [ratio]) of the assisted (source row, target column) pairs, None where unknown."""
        if not pairs:
            return None, None
        rows, columns = (list(side) for side in zip(*pairs, strict=True))
        mean_hue = float(circular_means(self.target_hue[None, columns] - self.source_hue[None, rows])[0])
        ratio = float(np.mean(self.target.volume[columns] / self.source.volume[rows]))
        return None if math.isnan(mean_hue) else mean_hue, ratio

    def hue_shift_layer(self, turn: float | Floats) -> Floats:
        """(n, m) similarity of hues turned by ``turn`` [deg]; (S, n, m) for (S, 1, 1) of them."""
        return _hue_layer(self.source_hue, self.target_hue, turn, self.config.sigma)

    def size_shift_layer(self, scale: float | Floats) -> Floats:
        """(n, m) similarity of volumes scaled by ``scale``; (S, n, m) for (S, 1, 1) of them."""
        ratio = self.target.volume[None, :] / self.source.volume[:, None]
        return similarity(ratio - scale, 1.0, self.config.sigma)

    def at(self, pairs: Sequence[tuple[int, int]]) -> tuple[Floats, tuple[bool, ...]]:
        """E (7, n, m) after the assists ``pairs`` and which of its layers exist."""
        mean_hue, mean_ratio = self.shifts(pairs)
        layers = self.fixed.copy()
        if mean_hue is not None:
            layers[HUE_SHIFT] = self.hue_shift_layer(mean_hue)
        if mean_ratio is not None:
            layers[SIZE_SHIFT] = self.size_shift_layer(mean_ratio)
        exists = [True] * NUM_FEATURES
        exists[HUE_SHIFT], exists[SIZE_SHIFT] = mean_hue is not None, mean_ratio is not None
        return layers, tuple(exists)


def _hue_layer(source: Floats, target: Floats, shift: float | Floats, sigma: float) -> Floats:
    """Hue (shift 0) or hue-shift similarity (n, m), grey objects as the module says."""
    difference = hue_difference(target[None, :], source[:, None] + shift)
    source_grey, target_grey = np.isnan(source)[:, None], np.isnan(target)[None, :]
    if source_grey.any() or target_grey.any():
        difference = np.where(source_grey | target_grey, GREY_DISTANCE, difference)
        difference = np.where(source_grey & target_grey, 0.0, difference)
    return similarity(difference, HUE_RANGE, sigma)
