"""What the teacher may have in mind: the hypotheses that strategy "evidence" weighs.

A hypothesis is a score over pairs, for which the teacher's mapping is best: a weighted mean of similarities
(``weighing.py``, with its shifts ``shifts.py``) or a closeness in rank (``orders.py``). How exactly it is best is its
level. EXACT: P(m | h) is uniform over the best mappings. MEASURED and LOOSE: P(m | h) is proportional to
exp(-gap / noise), gap being the total score that m lacks. One more teacher goes by nothing we measure: every mapping is
equally likely.

Everything is square here: N = max(n, m) with rows or columns of nothing, so that a sum over mappings is a permanent.
Beyond EXACT_SIZE objects a permanent of so many near-ties is out of reach: there the teacher of an inexact level takes
the objects in turn, and for each one of those left, j with probability proportional to exp(-slack_ij / noise).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from mbd_mapping.assignment.assignment import Columns, potentials
from mbd_mapping.assignment.permanent import EXACT_SIZE, log_permanents, marginals
from mbd_mapping.similarity import NUM_FEATURES, Comparison
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.choice_models import ChoiceModel, choice_models, named_features
from mbd_mapping.teachers.priors import Group, Level
from mbd_mapping.teachers.shifts import EXACT, Scored

GROUPS, LEVELS = tuple(Group), tuple(Level)
LEAST_NOISE = 1e-4  # features that are measured exactly: so little that only ties are near
LEAST_LOG_WEIGHT = -60.0  # as good as never; less makes numbers too small to calculate with quickly
FAR = 5.0  # in units of noise: shifts whose best mapping is worse than this hardly count


@dataclass(frozen=True)
class Hypotheses:
    """H hypotheses about what the teacher has in mind.

    Attributes:
        sets: the feature sets named by what the hypotheses go by, the first () for none.
        set_of: (H,) index into ``sets`` of each hypothesis.
        group, level: (H,) index into GROUPS and LEVELS.
        item: (H,) which score; the levels of one score share it.
        slack: (H, N, N) how much worse each pair is than the best mapping's, >= 0; sums to the gap of a mapping.
        weights: (H, N, N) exp(-slack / noise), 0 or 1 where exact.
        log_prior: (H,) log of prior probability over the sum of the weights of all mappings; over nothing in turn.
        indifference: (H,) a mapping whose slack is no more than this is as good as the best, as far as was measured.
        unique: (H,) True for hypotheses that hold one mapping of the real objects only.
        in_turn: (H,) True for those whose teacher takes the objects in turn.
        columns: (H, N) a mapping of greatest weight of each hypothesis: the only one where ``unique``.
        log_sum: (H,) log of the sum of the weights of all mappings, 0 in turn.
        sources, targets: n and m, the real objects; N is the larger.
    """

    sets: tuple[tuple[int, ...], ...]
    set_of: NDArray[np.intp]
    group: NDArray[np.intp]
    level: NDArray[np.intp]
    item: NDArray[np.intp]
    slack: Floats
    weights: Floats
    log_prior: Floats
    indifference: Floats
    unique: NDArray[np.bool_]
    in_turn: NDArray[np.bool_]
    columns: Columns
    log_sum: Floats
    sources: int
    targets: int

    @property
    def copies(self) -> int:
        """How many square mappings are the same real one: rows or columns of nothing are interchangeable."""
        return math.factorial(abs(self.sources - self.targets))

    @cached_property
    def exact_of(self) -> NDArray[np.intp]:
        """(H,) the exact hypothesis of the same score; itself where it is exact, or has none."""
        place = np.arange(len(self.item))
        exact = {int(self.item[h]): int(h) for h in np.flatnonzero(self.level == LEVELS.index(Level.EXACT))}
        return np.array([exact.get(int(i), int(h)) for h, i in zip(place, self.item, strict=True)])

    @cached_property
    def summed(self) -> NDArray[np.intp]:
        """Which hypotheses hold several mappings whose weights are summed: neither unique nor in turn."""
        return np.flatnonzero(~self.unique & ~self.in_turn)

    @cached_property
    def summed_weights(self) -> Floats:
        """(S, N, N) weights of those."""
        return self.weights[self.summed]

    @cached_property
    def marginals(self) -> Floats:
        """(S, N, N) probability of each pair with each of those, before anything is told."""
        return marginals(self.summed_weights)

    @cached_property
    def turn_weights(self) -> Floats:
        """(N, T, N) weights of the hypotheses in turn, row by row."""
        return np.ascontiguousarray(self.weights[self.in_turn].transpose(1, 0, 2))

    @cached_property
    def log_weights(self) -> Floats:
        """(H - T, N * N) logarithms of the weights of those not in turn, -inf for none."""
        with np.errstate(divide="ignore"):
            logs: Floats = np.log(self.weights[~self.in_turn]).reshape(-1, self.weights.shape[1] ** 2)
        return logs

    @cached_property
    def distinct(self) -> tuple[Columns, Columns]:
        """(the different mappings of the ``unique`` hypotheses (U, N), which of them each of those holds)."""
        mappings, place = np.unique(self.columns[self.unique], axis=0, return_inverse=True)
        return mappings, place.reshape(-1)

    @staticmethod
    def of(comparison: Comparison) -> Hypotheses:
        """Every hypothesis about these scenes."""
        priors = comparison.config.priors
        n, m = len(comparison.source), len(comparison.target)
        size, log_copies = max(n, m), math.lgamma(abs(n - m) + 1)
        teachers = choice_models(comparison)
        items = [item for teacher in teachers for item in teacher.items]
        best_gap, slack, columns = _stacked(items, n, m, teachers)
        shares = {g: priors.group(g) for g in dict.fromkeys(t.group for t in teachers)}
        whole = sum(shares.values()) + priors.group(Group.OTHER)
        totals = dict.fromkeys(shares, 0.0)
        for teacher in teachers:
            totals[teacher.group] += teacher.prior
        named = named_features(np.array([t.weights for t in teachers]).reshape(-1, NUM_FEATURES))
        names = dict.fromkeys([(), *named])
        place_of = {name: k for k, name in enumerate(names)}
        owner = np.array([k for k, t in enumerate(teachers) for _ in t.items], dtype=np.intp)
        item_group = np.array([GROUPS.index(t.group) for t in teachers], dtype=np.intp)[owner]
        item_set = np.array([place_of[name] for name in named], dtype=np.intp)[owner]
        noise = np.array([t.noise for t in teachers])[owner]
        prior = np.array([shares[t.group] / whole * t.prior / totals[t.group] for t in teachers])
        # A group nobody gives a chance costs nothing.
        wanted = prior[owner] > 0.0 if len(owner) else np.zeros(0, dtype=bool)
        parts: list[tuple[NDArray[np.intp], Level, Floats, Floats, NDArray[np.bool_], Floats]] = []
        level_sum = sum(priors.level(v) for v in Level)
        for level in Level:
            share = priors.level(level) / level_sum
            if not share or not items:
                continue
            if level == Level.EXACT:
                near = np.flatnonzero(wanted & (best_gap <= EXACT))
                weight = np.where(slack[near] <= EXACT, 1.0, 0.0)
                log_gap = np.zeros(len(near))
            else:
                spread = np.hypot(np.maximum(noise, LEAST_NOISE), priors.loose_noise if level == Level.LOOSE else 0.0)
                near = np.flatnonzero(wanted & (best_gap <= FAR * spread))
                weight = np.exp(np.maximum(-slack[near] / spread[near, None, None], LEAST_LOG_WEIGHT))
                log_gap = -best_gap[near] / spread[near]
            in_turn = level != Level.EXACT and size > EXACT_SIZE
            sums = np.zeros(len(near)) if in_turn else log_permanents(weight)
            total = np.full(len(teachers), -np.inf)
            np.logaddexp.at(total, owner[near], log_gap + sums)
            with np.errstate(divide="ignore"):
                log_prior = np.log(prior[owner[near]] * share) + log_gap - total[owner[near]]
            unique = (sums < log_copies + EXACT) & (level == Level.EXACT)
            parts.append((near, level, weight, log_prior, unique, sums))
        other = priors.group(Group.OTHER) / whole
        every = 0.0 if size > EXACT_SIZE else math.lgamma(size + 1)
        counts = [len(part[0]) for part in parts]
        chosen = np.concatenate([part[0] for part in parts]) if parts else np.zeros(0, dtype=np.intp)
        levels = np.repeat([LEVELS.index(part[1]) for part in parts], counts).astype(np.intp)
        exact = levels == LEVELS.index(Level.EXACT)
        return Hypotheses(
            sets=tuple(names),
            set_of=np.concatenate([[0], item_set[chosen]]),
            group=np.concatenate([[GROUPS.index(Group.OTHER)], item_group[chosen]]),
            level=np.concatenate([[LEVELS.index(Level.LOOSE)], levels]),
            item=np.concatenate([[-1], chosen]),
            slack=np.concatenate([np.zeros((1, size, size)), slack[chosen]]),
            weights=np.concatenate([np.ones((1, size, size)), *(part[2] for part in parts)]),
            log_prior=np.concatenate([[np.log(other) - every], *(part[3] for part in parts)]),
            indifference=np.concatenate([[EXACT], np.maximum(noise[chosen], EXACT)]),
            unique=np.concatenate([[size == 1], *(part[4] for part in parts)]).astype(bool),
            in_turn=np.concatenate([[size > EXACT_SIZE], ~exact & (size > EXACT_SIZE)]).astype(bool),
            columns=np.concatenate([np.arange(size)[None], columns[chosen]]),
            log_sum=np.concatenate([[every], *(part[5] for part in parts)]),
            sources=n,
            targets=m,
        )


@lru_cache(maxsize=8)
def hypotheses_of(comparison: Comparison) -> Hypotheses:
    """The hypotheses about these scenes, computed once: no assist changes them."""
    return Hypotheses.of(comparison)


def _stacked(
    items: Sequence[Scored], n: int, m: int, teachers: Sequence[ChoiceModel]
) -> tuple[Floats, Floats, Columns]:
    """(how much each item's best total is below the best of its teacher's (B,), slack (B, N, N), best mapping (B, N)).

    What is left over on the larger side goes to nothing, at no cost but what it would have scored.
    """
    size, count = max(n, m), len(items)
    score = np.zeros((count, size, size))
    columns = np.zeros((count, size), dtype=np.intp)
    every = np.arange(size)
    for place, item in enumerate(items):
        score[place, :n, :m] = item.score
        if n <= m:
            columns[place, :n] = item.columns
            columns[place, n:] = np.setdiff1d(every, item.columns) if n < m else ()
        else:
            columns[place] = _inverse(np.concatenate([item.columns, np.setdiff1d(every, item.columns)]))
    value = np.array([item.value for item in items])
    best = np.array([max(i.value for i in t.items) for t in teachers for _ in t.items])
    if not count:
        return value, score, columns
    own = np.take_along_axis(score, columns[:, :, None], axis=2)
    loss = own - score
    reached = potentials(np.take_along_axis(loss, columns[:, None, :], axis=2))
    of_owner = np.zeros_like(reached)
    np.put_along_axis(of_owner, columns, reached, axis=1)
    slack = np.maximum(loss + reached[:, :, None] - of_owner[:, None, :], 0.0)
    return np.maximum(best - value, 0.0), slack, columns


def _inverse(columns: Columns) -> Columns:
    return np.argsort(columns)
