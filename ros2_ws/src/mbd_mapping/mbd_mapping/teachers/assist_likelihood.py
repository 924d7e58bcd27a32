"""What the assists and answers reveal about a mapping when any of them may be wrong.

Each assist names a wrong target with a small probability, for itself; or, with some probability a session, two of all
the assists it could have are given for each other, which an error each would make far too unlikely. One that the
teacher has confirmed is certain. A "no" is wrong as rarely as an assist. One for a demonstrated step that may have been
about another object says nothing about this one if it was.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.assignment.permanent import TINY, sums
from mbd_mapping.config import MappingConfig
from mbd_mapping.strategy import NO_ANSWERS, Pair, QuestionAnswers
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.hypotheses import Hypotheses
from mbd_mapping.teachers.in_turn import log_of_mappings, log_of_told, shares_in_turn, turn_order

NEGLIGIBLE = 1e-14  # probability of a hypothesis that no longer has a say in where objects go


@dataclass(frozen=True)
class AssistLikelihood:
    """The assists as evidence: repeating one adds nothing.

    Attributes:
        likelihood: (N, N) probability of all claims about row i if its column is j, each wrong for itself.
        pairs: the claims, when no two contradict each other; else ().
        told: the claims, contradicting or not.
        free: which of ``pairs`` are not confirmed, and so may have been exchanged.
        swap: probability that two of those were given for each other; 0 when there are fewer than two.
        denied: (N, N) probability of the "no" answers alone.
    """

    likelihood: Floats
    pairs: tuple[Pair, ...]
    told: tuple[Pair, ...]
    free: tuple[int, ...]
    swap: float
    denied: Floats

    @cached_property
    def nothing_said(self) -> bool:
        """Whether there are no claims at all."""
        return not self.told and bool((self.denied == 1.0).all())

    @staticmethod
    def of(
        assists: Sequence[Pair], size: int, targets: int, config: MappingConfig, answers: QuestionAnswers = NO_ANSWERS
    ) -> AssistLikelihood:
        """Claims over N = ``size`` rows and columns, of which the first ``targets`` columns are objects."""
        distinct = tuple(dict.fromkeys(assists))
        denied = np.ones((size, size))
        for row, column in dict.fromkeys(answers.denied):
            denied[row] *= 1.0 - config.assist_error
            denied[row, column] *= config.assist_error / (1.0 - config.assist_error)
        likelihood, doubts = denied.copy(), dict(answers.doubts)
        for row, column in distinct:
            sure = (row, column) in answers.confirmed
            # It holds only if it is right and the step it was given for was about this row.
            error, doubt = config.assist_error, doubts.get((row, column), 0.0)
            wrong = 0.0 if sure else error + (1.0 - error) * doubt
            factor = np.full(size, wrong / max(1, targets - 1))
            factor[column] = 1.0 - wrong
            likelihood[row] *= factor
        rows, columns = {r for r, _ in distinct}, {c for _, c in distinct}
        consistent = len(rows) == len(columns) == len(distinct)
        pairs = distinct if consistent else ()
        free = tuple(k for k, pair in enumerate(pairs) if pair not in answers.confirmed)
        # Two of all that could be told were exchanged: that both are among those told grows with their number.
        among = len(free) * (len(free) - 1) / max(1, targets * (targets - 1))
        return AssistLikelihood(likelihood, pairs, distinct, free, config.swap_error * min(1.0, among), denied)

    def exchanged(self) -> Columns:
        """(K, k): columns of the k claims with each two unconfirmed ones exchanged."""
        columns = np.array([c for _, c in self.pairs], dtype=np.intp)
        pairs = list(itertools.combinations(self.free, 2))
        out = np.tile(columns, (len(pairs), 1))
        for place, (a, b) in enumerate(pairs):
            out[place, [a, b]] = columns[[b, a]]
        return out

    def of_mappings(self, mappings: Columns) -> Floats:
        """(C,): probability of the claims given each mapping (C, N)."""
        rows = np.arange(mappings.shape[1])
        each: Floats = self.likelihood[rows, mappings].prod(axis=1)
        if not self.swap:
            return each
        claimed = mappings[:, [r for r, _ in self.pairs]]
        hit: Floats = (claimed[:, None, :] == self.exchanged()[None, :, :]).all(axis=2).mean(axis=1)
        both: Floats = (1.0 - self.swap) * each + self.swap * hit * self.denied[rows, mappings].prod(axis=1)
        return both

    def log_prior_of(self, hypotheses: Hypotheses, mappings: Columns) -> Floats:
        """(H, C): log prior probability, with each hypothesis, of each square mapping (C, N)."""
        size = mappings.shape[1]
        out = np.empty((len(hypotheses.weights), len(mappings)))
        turn = hypotheses.in_turn
        places = np.arange(size) * size + mappings
        out[~turn] = hypotheses.log_weights.take(places, axis=1).sum(axis=2)
        if turn.any():
            out[turn] = log_of_mappings(hypotheses.turn_weights, mappings, turn_order(size, self.told))
        return out + hypotheses.log_prior[:, None]

    def given(self, hypotheses: Hypotheses) -> tuple[Floats, Floats]:
        """What the claims make of the hypotheses.

        Returns:
            (H,) log of the sum, over the mappings of each, of prior probability times that of the claims, the
            hypothesis's own prior included; (N, N) probability that row i goes to column j, given the claims.
        """
        size = hypotheses.weights.shape[1]
        logs = np.empty(len(hypotheses.weights))
        one, turn, several = hypotheses.unique, hypotheses.in_turn, hypotheses.summed
        with np.errstate(divide="ignore"):
            logs[one] = np.log(hypotheses.copies * self.of_mappings(hypotheses.columns[one]))
        if self.nothing_said:
            logs[several], of_several = hypotheses.log_sum[several], hypotheses.marginals
        else:
            logs[several], of_several = self._summed(hypotheses.summed_weights)
        if turn.any():
            logs[turn] = log_of_told(hypotheses.weights[turn], self.likelihood, self.told)
        logs += hypotheses.log_prior
        probability = np.exp(logs - np.logaddexp.reduce(logs))
        share: Floats = np.einsum("h,hij->ij", probability[several], of_several)
        np.add.at(share, (np.arange(size), hypotheses.columns[one]), probability[one][:, None])
        # Rows of nothing are alike, and so are columns of nothing: no mapping is counted more than once in turn.
        likely = np.flatnonzero(turn & (probability > NEGLIGIBLE))
        in_turn = shares_in_turn(hypotheses.weights[likely] * self.likelihood)
        share += np.einsum("h,hij->ij", probability[likely], in_turn)
        return logs, share

    def _summed(self, weights: Floats) -> tuple[Floats, Floats]:
        """The same (without prior) by permanents of ``weights`` (H, N, N)."""
        each, share = sums(weights * self.likelihood)
        if not self.swap:
            return each, share
        size = weights.shape[1]
        rows, columns = (np.array(side, dtype=np.intp) for side in zip(*self.pairs, strict=True))
        is_free = np.ones((2, size), dtype=bool)
        is_free[0, rows] = is_free[1, columns] = False
        rest = np.flatnonzero(is_free[0])[:, None], np.flatnonzero(is_free[1])[None, :]
        weighed = weights * self.denied
        exchanged = self.exchanged()
        known: Floats = weighed[:, rows[None, :], exchanged].prod(axis=2)
        possible = np.flatnonzero(known.mean(axis=1) > 0.0)
        if not possible.size:
            return each + np.log1p(-self.swap), share
        parts = weighed[possible][:, rest[0], rest[1]]
        found, of_rest = sums(parts) if parts.shape[1] else (np.zeros(len(parts)), parts)
        swapped = np.full(len(weights), -np.inf)
        swapped[possible] = np.log(self.swap * known[possible].mean(axis=1)) + found
        both = np.logaddexp(np.log1p(-self.swap) + each, swapped)
        part = np.exp(swapped[possible] - np.where(np.isfinite(both[possible]), both[possible], 0.0))[:, None, None]
        other = np.zeros((len(possible), size, size))
        other[:, rest[0], rest[1]] = of_rest
        chosen = known[possible] / np.maximum(known[possible].sum(axis=1, keepdims=True), TINY)
        # Every claimed row keeps its column, or has that of the claim it was exchanged with.
        for place, chosen_columns in enumerate(exchanged):
            other[:, rows, chosen_columns] += chosen[:, place, None]
        share[possible] = (1.0 - part) * share[possible] + part * other
        return both, share
