"""What the teacher may have in mind: the hypotheses that strategy "evidence" weighs.

A teacher goes by a feature set f and wants a mapping that is best for it: P(m | f) is uniform over f's best mappings.
Where f names a shift, the shift is one more unknown: the mapping and the shift must be best for each other. With
``similarity_noise`` the robot allows for its own measuring errors, by which the teacher's best mapping may look
slightly worse: P(m | f) is half of the above and half proportional to exp(-gap / noise), gap being the total similarity
that m lacks. One more teacher goes by none of the features: every mapping is equally likely.

Everything is square here: N = max(n, m) with rows or columns of nothing, so that a sum over mappings is a permanent.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from mbd_mapping.assignment.assignment import Columns, best_assignment, potentials, total
from mbd_mapping.assignment.permanent import log_permanents
from mbd_mapping.feature_sets import feature_sets, varying_features
from mbd_mapping.similarity import HUE_SHIFT, SIZE_SHIFT, Comparison
from mbd_mapping.tables import Floats

SHIFTS = frozenset({HUE_SHIFT, SIZE_SHIFT})
MAX_TURNS = 20
MAX_STARTS = 64
MAX_SHIFTS = 4
EXACT = 1e-9


@dataclass(frozen=True)
class Hypotheses:
    """H hypotheses about what the teacher has in mind.

    Attributes:
        sets: the feature sets, the first () for the teacher who goes by none.
        set_of: (H,) index into ``sets`` of each hypothesis.
        slack: (H, N, N) how much worse each pair is than the best mapping's, >= 0; sums to the gap of a mapping.
        weights: (H, N, N) exp(-slack / noise); their permanent is the hypothesis's sum over mappings.
        log_prior: (H,) log of prior probability over that sum: a mapping m has prior
            sum_h exp(log_prior_h) prod_i weights[h, i, m(i)].
        noise: (H,) what slack is divided by; 0 for exact hypotheses, inf for the teacher who goes by none.
        unique: (H,) True for hypotheses that hold one mapping of the real objects only.
        columns: (H, N) a mapping of greatest weight of each hypothesis: the only one where ``unique``.
        sources, targets: n and m, the real objects; N is the larger.
    """

    sets: tuple[tuple[int, ...], ...]
    set_of: NDArray[np.intp]
    slack: Floats
    weights: Floats
    log_prior: Floats
    noise: Floats
    unique: NDArray[np.bool_]
    columns: Columns
    sources: int
    targets: int

    @property
    def copies(self) -> int:
        """How many square mappings are the same real one: rows or columns of nothing are interchangeable."""
        return math.factorial(abs(self.sources - self.targets))

    @cached_property
    def distinct(self) -> tuple[Columns, Columns]:
        """(the different mappings of the ``unique`` hypotheses (U, N), which of them each of those holds)."""
        mappings, place = np.unique(self.columns[self.unique], axis=0, return_inverse=True)
        return mappings, place.reshape(-1)

    @staticmethod
    def of(comparison: Comparison) -> Hypotheses:
        """Every hypothesis about these scenes."""
        config = comparison.config
        members = feature_sets(config.feature_space)
        # Who goes by what is the same for all objects goes by nothing: that hypothesis is there already.
        alive = members[:, varying_features(comparison, range(len(comparison.source)))].any(axis=1)
        sets = [tuple(int(k) for k in np.flatnonzero(row)) for row in members[alive]]
        prior = np.array([config.large_set_odds if len(s) > 2 else 1.0 for s in sets])
        no_feature = config.no_feature if sets else 1.0
        prior = (1.0 - no_feature) * prior / max(prior.sum(), 1.0)
        n, m = len(comparison.source), len(comparison.target)
        size, log_copies = max(n, m), math.lgamma(abs(n - m) + 1)
        levels = [0.0] if config.similarity_noise == 0 else [0.0, config.similarity_noise]
        set_of = [0]
        blocks = [np.zeros((1, size, size))]
        weights = [np.ones((1, size, size))]
        log_prior = [np.log(no_feature) - log_permanents(weights[0])]
        noise, unique, mappings = [np.inf], [size == 1], [np.arange(size)[None]]
        for place, (chosen, share) in enumerate(zip(sets, prior, strict=True), start=1):
            # Larger sets hardly count; for them a few starts do.
            starts = MAX_STARTS if len(chosen) <= 2 else MAX_STARTS // 8
            gaps, slack, columns = _stacked(shift_hypotheses(comparison, chosen, starts), size)
            for level in levels:
                near = gaps <= (EXACT if level == 0 else 5 * level)
                weight = np.where(slack[near] <= EXACT, 1.0, 0.0) if level == 0 else np.exp(-slack[near] / level)
                log_gap = np.zeros(near.sum()) if level == 0 else -gaps[near] / level
                sums = log_permanents(weight)
                total_weight = np.logaddexp.reduce(log_gap + sums)
                set_of += [place] * int(near.sum())
                unique += [bool(s < log_copies + EXACT) for s in sums] if level == 0 else [False] * int(near.sum())
                blocks.append(slack[near])
                mappings.append(columns[near])
                weights.append(weight)
                log_prior.append(np.log(share / len(levels)) + log_gap - total_weight)
                noise += [level] * int(near.sum())
        return Hypotheses(
            ((), *sets),
            np.array(set_of),
            np.concatenate(blocks),
            np.concatenate(weights),
            np.concatenate(log_prior),
            np.array(noise),
            np.array(unique),
            np.concatenate(mappings),
            n,
            m,
        )


@lru_cache(maxsize=8)
def hypotheses_of(comparison: Comparison) -> Hypotheses:
    """The hypotheses about these scenes, computed once: no assist changes them."""
    return Hypotheses.of(comparison)


def shift_hypotheses(comparison: Comparison, features: Sequence[int], starts: int) -> list[tuple[float, Floats]]:
    """(total of the best mapping, score (n, m)) of each shift the set may mean, best first; one for other sets."""
    n, m = len(comparison.source), len(comparison.target)
    chosen = list(features)
    if not SHIFTS & set(features) or not n or not m:
        layers, _ = comparison.at(())
        score = layers[chosen].mean(axis=0)
        return [(total_of_best(score), score)]
    found: dict[tuple[int, ...], tuple[float, Floats]] = {}
    for start in _starts(n, m, starts):
        pairs = [start]
        for _ in range(MAX_TURNS):
            layers, _ = comparison.at(pairs)
            score = layers[chosen].mean(axis=0)
            pairs = matched_pairs(score)
            key = tuple(c for _, c in pairs)
            if key in found:
                break
            layers, _ = comparison.at(pairs)
            own = layers[chosen].mean(axis=0)
            found[key] = sum(own[r, c] for r, c in pairs), own
    ranked = sorted(found.values(), key=lambda item: -item[0])
    return ranked[:MAX_SHIFTS]


def matched_pairs(score: Floats) -> list[tuple[int, int]]:
    """The pairs of a best assignment of any (n, m)."""
    if score.shape[0] <= score.shape[1]:
        return [(r, int(c)) for r, c in enumerate(best_assignment(score))]
    return sorted((int(r), c) for c, r in enumerate(best_assignment(score.T)))


def total_of_best(score: Floats) -> float:
    """Total of a best assignment of any (n, m)."""
    return float(sum(score[r, c] for r, c in matched_pairs(score)))


def _starts(n: int, m: int, limit: int) -> Iterator[tuple[int, int]]:
    every = list(itertools.product(range(n), range(m)))
    return iter(every[:: -(-len(every) // limit)])


def _stacked(hypotheses: Sequence[tuple[float, Floats]], size: int) -> tuple[Floats, Floats, Columns]:
    """(gap of each hypothesis's best total to the best of all (L,), slack (L, N, N), a best mapping of each (L, N))."""
    values = np.array([value for value, _ in hypotheses])
    score = np.zeros((len(hypotheses), size, size))
    for place, (_, block) in enumerate(hypotheses):
        score[place, : block.shape[0], : block.shape[1]] = block
    columns = np.array([best_assignment(block) for block in score])
    best = np.array([total(block, chosen) for block, chosen in zip(score, columns, strict=True)])
    values = np.maximum(values, best)
    own = np.take_along_axis(score, columns[:, :, None], axis=2)
    loss = own - score
    moves = np.take_along_axis(loss, columns[:, None, :], axis=2)
    reached = potentials(moves)
    of_owner = np.zeros_like(reached)
    np.put_along_axis(of_owner, columns, reached, axis=1)
    slack = np.maximum(loss + reached[:, :, None] - of_owner[:, None, :], 0.0)
    return values.max() - values, slack, columns
