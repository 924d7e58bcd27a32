"""Every way of choosing a mapping that teachers may have, but for going by nothing we measure.

By weights of the features (``weighing.py``), with the shifts each may mean (``shifts.py``), or by order
(``orders.py``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mbd_mapping.feature_sets import varying_features
from mbd_mapping.similarity import HUE_SHIFT, NUM_FEATURES, SIZE_SHIFT, Comparison
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.noise import layer_noise
from mbd_mapping.teachers.orders import order_scores
from mbd_mapping.teachers.priors import Group
from mbd_mapping.teachers.shifts import MAX_SHIFTS, Scored, ShiftSearch, scored
from mbd_mapping.teachers.weighing import weight_vectors


@dataclass(frozen=True)
class ChoiceModel:
    """One way of choosing a mapping, with the shifts it may mean.

    Attributes:
        group: what kind.
        weights: (7,) of the features; zeros for an order.
        items: what it may want, best first.
        noise: of its score when measured.
        prior: relative to the others of its group.
    """

    group: Group
    weights: Floats
    items: tuple[Scored, ...]
    noise: float
    prior: float


def named_features(weights: Floats) -> list[tuple[int, ...]]:
    """The features each teacher is named by, of weights (T, 7): those of half the mean weight; () for an order."""
    used = np.maximum((weights > 0).sum(axis=1, keepdims=True), 1)
    named = (weights > 0) & (weights >= 0.5 * weights.sum(axis=1, keepdims=True) / used)
    return [tuple(k for k in range(NUM_FEATURES) if row[k]) for row in named.tolist()]


def choice_models(comparison: Comparison) -> list[ChoiceModel]:
    """Everyone but the one who goes by nothing we measure."""
    config = comparison.config
    n, m = len(comparison.source), len(comparison.target)
    if not n or not m:
        return []
    varying = varying_features(comparison, range(n)).astype(float)
    if not varying.any():
        # Nothing tells the source objects apart, but targets may still be more or less like them.
        varying = np.zeros(NUM_FEATURES)
    noise = layer_noise(comparison)
    logs = np.log(config.priors.features)
    vectors = [v for v in weight_vectors(varying, config.feature_space, max(n, m)) if config.priors.group(v[0]) > 0.0]
    found = []
    for group, weights, items in _with_items(vectors, comparison):
        used = weights > 0
        prior = math.exp(logs[used].mean())
        own = math.hypot(*(weights * noise).tolist())
        found.append(ChoiceModel(group, weights, tuple(items), own, prior))
    for group, score in order_scores(comparison.source, comparison.target):
        found.append(ChoiceModel(group, np.zeros(NUM_FEATURES), (scored(score),), config.similarity_noise, 1.0))
    return found


def _with_items(
    vectors: Sequence[tuple[Group, Floats]], comparison: Comparison
) -> Iterator[tuple[Group, Floats, Sequence[Scored]]]:
    """Each weight vector (7,) with what its teacher may want, where there is anything."""
    search = ShiftSearch(comparison)
    # Every single shift starts from everywhere, the others from where the single ones have ended.
    starts = search.starts()
    ends: list[tuple[float, float]] = [(0.0, 1.0)]
    for group in Group:
        own = [weights for g, weights in vectors if g == group]
        fixed = [w for w in own if not w[HUE_SHIFT] and not w[SIZE_SHIFT]]
        shifting = [w for w in own if w[HUE_SHIFT] or w[SIZE_SHIFT]]
        scores = np.tensordot(np.array(fixed).reshape(-1, NUM_FEATURES), comparison.fixed, axes=1)
        for weights, score in zip(fixed, scores, strict=True):
            yield group, weights, [scored(score)]
        if not shifting:
            continue
        keep = MAX_SHIFTS if group == Group.SINGLE else 2 if group == Group.PAIR else 1
        from_where = starts if group == Group.SINGLE else ends
        for weights, items in zip(shifting, search.solve(np.array(shifting), from_where, keep), strict=True):
            if items:
                yield group, weights, items
                ends += [search.shift_of(item.columns) for item in items[:2]] if group == Group.SINGLE else []
