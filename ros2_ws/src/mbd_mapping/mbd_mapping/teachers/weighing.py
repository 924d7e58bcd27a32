"""Which weights of the seven features teachers may have: sets, equally, and a fixed spread of unequal ones."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np

from mbd_mapping.config import FeatureSpace
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.priors import NUM_FEATURES, Group

# Positive root of x^8 = x + 1: its powers spread points over seven dimensions evenly (Roberts 2018).
ROOT = 1.0969815577985598


@cache
def spread_weights(count: int) -> Floats:
    """(count, 7) exponential variates of an additive recurrence: over any features, divided by their sum, Dirichlet."""
    steps = ROOT ** -(np.arange(NUM_FEATURES) + 1.0)
    uniform = (0.5 + np.arange(1, count + 1)[:, None] * steps[None, :]) % 1.0
    weights: Floats = -np.log1p(-uniform)
    weights.setflags(write=False)
    return weights


def how_many_spread(size: int) -> int:
    """How many unequal weight vectors are affordable for this many objects."""
    return 32 if size <= 12 else 16 if size <= 40 else 6


def weight_vectors(varying: Floats, space: FeatureSpace, size: int) -> list[tuple[Group, Floats]]:
    """(group, weights (7,) that sum to 1) of every teacher who weighs features, over those that vary ((7,) 0 or 1).

    A set with a feature that does not vary maps as the set without it, and is there already.
    """
    alive = [int(k) for k in np.flatnonzero(varying)]
    largest = len(alive) if space == FeatureSpace.ALL else 2
    found: list[tuple[Group, Floats]] = []
    for count in range(1, largest + 1):
        group = Group.SINGLE if count == 1 else Group.PAIR if count == 2 else Group.LARGER
        for chosen in itertools.combinations(alive, count):
            weights = np.zeros(NUM_FEATURES)
            weights[list(chosen)] = 1.0 / count
            found.append((group, weights))
    if len(alive) > 1:
        for spread in spread_weights(how_many_spread(size)):
            weights = spread * varying
            found.append((Group.WEIGHTED, weights / weights.sum()))
    return found
