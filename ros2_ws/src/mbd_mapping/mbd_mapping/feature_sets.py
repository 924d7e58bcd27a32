"""F of Algorithm 1: which feature sets compete, and which the assists prune."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mbd_mapping.config import FeatureSpace
from mbd_mapping.similarity import NUM_FEATURES, Comparison, hue_difference

Bools = NDArray[np.bool_]


@cache
def feature_sets(space: FeatureSpace) -> Bools:
    """(S, 7) membership, smaller sets first: 7 single features, or all 127 non-empty sets. Read-only."""
    sizes = (1,) if space == FeatureSpace.SINGLE else range(1, NUM_FEATURES + 1)
    chosen = [c for size in sizes for c in itertools.combinations(range(NUM_FEATURES), size)]
    members = np.zeros((len(chosen), NUM_FEATURES), dtype=bool)
    for row, features in enumerate(chosen):
        members[row, list(features)] = True
    members.setflags(write=False)
    return members


def varying_features(comparison: Comparison, rows: Sequence[int]) -> Bools:
    """(7,): does the feature vary, by more than its tolerance, over these source objects?"""
    if len(rows) < 2:
        return np.zeros(NUM_FEATURES, dtype=bool)
    config, table, index = comparison.config, comparison.source, list(rows)
    hue, volume = comparison.source_hue[index], table.volume[index]
    grey = np.isnan(hue)
    known = hue[~grey]
    hue_varies = bool(grey.any() and known.size) or bool(
        known.size > 1 and np.abs(hue_difference(known[:, None], known[None, :])).max() > config.hue_tolerance
    )
    size_varies = bool(volume.max() / volume.min() - 1.0 > config.size_tolerance)
    relations = table.relations[index]
    spatial_varies = bool((relations != relations[0]).any())
    affordance_varies = any(table.affordances[row] != table.affordances[index[0]] for row in index)
    property_varies = any(table.properties[row] != table.properties[index[0]] for row in index)
    return np.array(
        [hue_varies, hue_varies, size_varies, size_varies, spatial_varies, affordance_varies, property_varies]
    )


def surviving_sets(comparison: Comparison, members: Bools, pairs: Sequence[tuple[int, int]]) -> Bools:
    """(S,): the sets left before any assist and after these (row, column) assists, one after the other.

    A step that would empty F leaves it as it was.
    """
    alive = np.ones(len(members), dtype=bool)
    unassisted = list(range(len(comparison.source)))
    for row in (None, *(row for row, _ in pairs)):
        if row is not None:
            unassisted.remove(row)
        left = alive & members[:, varying_features(comparison, unassisted)].any(axis=1)
        if left.any():
            alive = left
    return alive
