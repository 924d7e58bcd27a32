"""Strategy "mbd": the paper's rule, Algorithm 1 with eq. 3-7, exactly and in polynomial time.

V(m, f) / (n |f|) is the mean, over the n mapped objects and the features of f, of their similarity. The best mapping of
one f is an assignment problem. That mean over a set is at most the mean of what each of its features reaches alone,
which bounds every set from above, so most of the 127 are never solved. Where the scenes differ in size, n counts the
pairs a mapping can have, min(n, m): a missing object lowers no confidence by itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from mbd_mapping.assignment.assignment import Columns, Detours, best_assignment, total
from mbd_mapping.assignment.ties import optimal_assignments
from mbd_mapping.config import MappingConfig
from mbd_mapping.feature_sets import Bools, feature_sets, surviving_sets
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import NO_ANSWERS, UNMAPPED, Pair, Prediction, QuestionAnswers, first_assists
from mbd_mapping.tables import Floats

TRIED_PER_TIE = 20


class Competition:
    """The feature sets of one inference with their best mappings, solved when asked for.

    Args:
        layers: E (7, n, m), n <= m.
        members: (S, 7) the competing sets, every feature of them existing.
        pairs: the assists in force, as (row, column), no row or column twice.
        tolerance: how close two values are to be the same.
    """

    def __init__(self, layers: Floats, members: Bools, pairs: Sequence[Pair], tolerance: float) -> None:
        _, self.n, self.m = layers.shape
        self.members, self.tolerance = members, tolerance
        taken_rows, taken_columns = {r for r, _ in pairs}, {c for _, c in pairs}
        self.rows = np.array([r for r in range(self.n) if r not in taken_rows], dtype=np.intp)
        self.open = np.array([c for c in range(self.m) if c not in taken_columns], dtype=np.intp)
        self.given = np.full(self.n, UNMAPPED)
        for row, column in pairs:
            self.given[row] = column
        # Divided by n once, so that every value below is V / (n |f|).
        self.blocks: Floats = layers[:, self.rows[:, None], self.open[None, :]] / self.n
        self.base = sum((layers[:, r, c] for r, c in pairs), np.zeros(len(layers))) / self.n
        self.shares = members / members.sum(axis=1, keepdims=True)
        self._solved: dict[int, tuple[float, Columns]] = {}
        self._scores = np.tensordot(self.shares, self.blocks, axes=1)
        self._offsets = self.shares @ self.base
        self._detours: dict[int, Detours] = {}

    def block(self, f: int) -> Floats:
        """Scores of set ``f`` over unassisted rows and open columns."""
        score: Floats = self._scores[f]
        return score

    def offset(self, f: int) -> float:
        """What the assists contribute to the value of set ``f``."""
        return float(self._offsets[f])

    def detours(self, f: int) -> Detours:
        """Every departure from the best mapping of set ``f``."""
        if f not in self._detours:
            self._detours[f] = Detours.around(self.block(f), self.solve(f)[1])
        return self._detours[f]

    def solve(self, f: int) -> tuple[float, Columns]:
        """(value, columns within the block) of the best mapping of set ``f``."""
        if f not in self._solved:
            score = self.block(f)
            columns = best_assignment(score)
            self._solved[f] = (self.offset(f) + total(score, columns), columns)
        return self._solved[f]

    @property
    def solved(self) -> list[int]:
        """The sets solved so far, in the order of F."""
        return sorted(self._solved)

    @cached_property
    def bounds(self) -> Floats:
        """(S,): no mapping gives set f a value above this; equal to the value for single features."""
        alone = np.zeros(self.blocks.shape[0])
        for k in np.flatnonzero(self.members.any(axis=0)):
            alone[k] = self.base[k] + total(self.blocks[k], best_assignment(self.blocks[k]))
        bounds: Floats = self.shares @ alone
        return bounds

    @cached_property
    def order(self) -> list[int]:
        """Sets by falling bound, earlier sets first among equals."""
        return [int(f) for f in np.argsort(-self.bounds, kind="stable")]

    @cached_property
    def contenders(self) -> list[int]:
        """The sets that share the best value, in the order of F; the first is alpha."""
        best = -np.inf
        for f in self.order:
            if self.bounds[f] < best - 2 * self.tolerance:
                break
            best = max(best, self.solve(f)[0])
        return sorted(f for f, (value, _) in self._solved.items() if value >= best - self.tolerance)

    def expand(self, columns: Columns) -> tuple[int, ...]:
        """Columns of the complete problem from columns of the block."""
        whole = self.given.copy()
        whole[self.rows] = self.open[columns]
        return tuple(int(c) for c in whole)

    def runner_up(self, alpha: int) -> tuple[int, float] | None:
        """(beta, value): the best other set none of whose best mappings is one of alpha's (eq. 6); None if none."""
        columns = self.solve(alpha)[1]
        detours = self.detours(alpha)
        unique = detours.margin > self.tolerance
        found: tuple[int, float] | None = None
        for f in self.order:
            if found is not None and self.bounds[f] < found[1] - self.tolerance:
                break
            if f == alpha:
                continue
            own = self.solve(f)[0]
            if found is not None and own <= found[1]:
                continue
            score = self.block(f)
            if self.offset(f) + total(score, columns) >= own - self.tolerance:
                continue
            shared = columns if unique else detours.best_among_optimal(score, self.tolerance)
            if self.offset(f) + total(score, shared) < own - self.tolerance:
                found = (f, own)
        return found

    def tied(self, limit: int) -> list[tuple[tuple[int, ...], float]]:
        """All mappings that share the best value, up to ``limit``, the best first."""
        best = self.solve(self.contenders[0])[0]
        best = max(best, *(self.solve(f)[0] for f in self.contenders))
        found: dict[tuple[int, ...], float] = {}
        for f in self.contenders:
            if len(found) >= limit:
                break
            # Pairs that each miss the best by less than the tolerance may miss it by more together: a run of such
            # mappings is not followed without end.
            candidates = optimal_assignments(self.detours(f), self.tolerance)
            for columns in itertools.islice(candidates, TRIED_PER_TIE * limit):
                value = self.offset(f) + total(self.block(f), columns)
                if len(found) >= limit:
                    break
                if value >= best - self.tolerance:
                    found.setdefault(self.expand(columns), value)
        return list(found.items())


def infer_mbd(
    comparison: Comparison, assists: Sequence[Pair], askable: Sequence[int], answers: QuestionAnswers = NO_ANSWERS
) -> Prediction:
    """Algorithm 1 and eq. 3-7. The first of contradicting assists stands, as in the study.

    ``askable`` only gives the next question: the paper asks in task order. ``answers`` say nothing to it: every assist
    is certain already, and it asks no other question. Where mappings tie and no other feature set competes, eq. 7
    leaves the whole value as confidence; that is shared among them, for one of several equals is a guess.
    """
    config = comparison.config
    pairs = first_assists(assists)
    layers, exists = comparison.at(pairs)
    members = competing_sets(comparison, pairs, exists)
    swapped = layers.shape[1] > layers.shape[2]
    if swapped:
        layers, oriented = layers.transpose(0, 2, 1), [(c, r) for r, c in pairs]
    else:
        oriented = list(pairs)
    n = len(comparison.source)

    def upright(columns: tuple[int, ...]) -> tuple[int, ...]:
        if not swapped:
            return columns
        rows = [UNMAPPED] * n
        for column, row in enumerate(columns):
            rows[row] = column
        return tuple(rows)

    next_row = askable[0] if askable else UNMAPPED
    if 0 in layers.shape or not len(members):
        return Prediction((UNMAPPED,) * n, 0.0, 0.0, next_row=next_row)
    race = Competition(layers, members, oriented, config.tie_tolerance)
    alpha = race.contenders[0]
    value, columns = race.solve(alpha)
    beta = race.runner_up(alpha)
    tied = race.tied(config.max_ties)
    mapping = race.expand(columns)
    return Prediction(
        columns=upright(mapping),
        score=value,
        confidence=min(1.0, max(0.0, value - beta[1] if beta else value / len(tied))),
        winning=_indices(members[alpha]),
        runner_up=_indices(members[beta[0]]) if beta else (),
        alternatives=tuple((upright(c), v) for c, v in _alternatives(race, mapping, tied, config)),
        ties=len(tied),
        next_row=next_row,
    )


def competing_sets(comparison: Comparison, pairs: Sequence[Pair], exists: Sequence[bool]) -> Bools:
    """(S, 7): F after these assists, without the sets that name a shift not measured yet."""
    members = feature_sets(comparison.config.feature_space)
    alive = surviving_sets(comparison, members, pairs)
    measured = ~(members & ~np.array(exists)).any(axis=1)
    # Pruning may leave nothing but shifts that only grey objects assist: then every measured set competes again.
    competing = alive & measured if (alive & measured).any() else measured
    chosen: Bools = members[competing]
    return chosen


def _alternatives(
    race: Competition, mapping: tuple[int, ...], tied: list[tuple[tuple[int, ...], float]], config: MappingConfig
) -> list[tuple[tuple[int, ...], float]]:
    """Tied mappings, then what the other solved feature sets would rather do, best first."""
    others = dict(tied)
    for f in race.solved:
        value, columns = race.solve(f)
        other = race.expand(columns)
        others[other] = max(value, others.get(other, 0.0))
    others.pop(mapping, None)
    return sorted(others.items(), key=lambda item: -item[1])[: config.max_alternatives]


def _indices(member: Bools) -> tuple[int, ...]:
    return tuple(int(k) for k in np.flatnonzero(member))
