"""Strategy "evidence": weigh every kind of teacher by how well what they would want explains all assists.

The posterior over mappings is exact for the model of ``hypotheses`` and ``assist_likelihood`` up to the size where a
permanent can be summed: P(m | A) = sum_h P(h) P(m | h) P(A | m) / P(A). An assist that is wrong costs its hypothesis a
factor; none is excluded unless the teacher has confirmed another. The confidence is the posterior probability that the
mapping is right: that it is the teacher's, or as good for what the teacher goes by as far as it was measured.

The mapping carried out holds every assist in force, unless one is so improbable given everything else that it is to be
asked about first: then the best guess is shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from mbd_model.estimate import QuestionKind

from mbd_mapping.assignment.assignment import Columns
from mbd_mapping.assignment.candidates import SAME, candidates
from mbd_mapping.question import answer_gain, best_question
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import (
    NO_ANSWERS,
    UNMAPPED,
    Pair,
    Prediction,
    QuestionAnswers,
    Reading,
    assists_in_force,
)
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.assist_likelihood import AssistLikelihood
from mbd_mapping.teachers.hypotheses import Hypotheses, hypotheses_of

CONSIDERED = 8  # of the most probable mappings: the one most probably right is among them


@dataclass(frozen=True)
class Posterior:
    """Everything the claims say.

    Attributes:
        hypotheses: about the teacher.
        likelihoods: of the claims.
        log_joint: (H,) log probability of each hypothesis with the claims.
        log_evidence: log probability of the claims.
        probability: (H,) of each hypothesis given the claims.
        share: (N, N) probability that row i goes to column j.
        squares: (C, N) the mappings considered.
        joint: (H, C) probability of hypothesis and mapping.
        scores: (C,) probability of each mapping.
    """

    hypotheses: Hypotheses
    likelihoods: AssistLikelihood
    log_joint: Floats
    log_evidence: float
    probability: Floats
    share: Floats
    squares: Columns
    joint: Floats
    scores: Floats

    @staticmethod
    def of(hypotheses: Hypotheses, likelihoods: AssistLikelihood) -> Posterior:
        """Weigh the hypotheses and find the mappings worth considering."""
        log_joint, share = likelihoods.given(hypotheses)
        log_evidence = float(np.logaddexp.reduce(log_joint))
        probability = np.exp(log_joint - log_evidence)
        squares = candidates(hypotheses, likelihoods, probability, share)
        log_prior = likelihoods.log_prior_of(hypotheses, squares)
        joint = np.exp(log_prior - log_evidence) * likelihoods.of_mappings(squares) * hypotheses.copies
        return Posterior(
            hypotheses,
            likelihoods,
            log_joint,
            log_evidence,
            probability,
            share,
            squares,
            joint,
            np.minimum(1.0, joint.sum(axis=0)),
        )

    def ranked(self) -> Columns:
        """Places of the mappings, the most probable first."""
        return np.argsort(-self.scores, kind="stable")

    def joint_of(self, square: Columns) -> Floats:
        """(H,) probability of each hypothesis and a mapping (N,)."""
        known = np.flatnonzero((self.squares == square).all(axis=1))
        if known.size:
            found: Floats = self.joint[:, known[0]]
            return found
        log_prior = self.likelihoods.log_prior_of(self.hypotheses, square[None])[:, 0] - self.log_evidence
        own: Floats = np.exp(log_prior) * self.likelihoods.of_mappings(square[None])[0] * self.hypotheses.copies
        return own

    def good(self, square: Columns) -> Floats:
        """(H,) probability that the hypothesis holds and the mapping (N,) is as good as what its teacher wants.

        Mappings that are worse for a hypothesis by no more than measuring errors are as good: nobody can tell from
        what is measured that the teacher minds. They are all right when one of them is wanted, at any level.
        """
        h, size = self.hypotheses, len(square)
        own = self.joint_of(square)
        near = h.slack[:, np.arange(size), square].sum(axis=1) <= h.indifference
        exact = h.exact_of
        # Their weights are 1 at every level, so the tied ones together have what they have where only they count.
        known = near & (h.group != 0) & ~h.in_turn & ~h.in_turn[exact] & (exact != np.arange(len(exact)))
        tied = np.exp(self.log_joint[exact] - h.log_prior[exact] + h.log_prior - self.log_evidence)
        is_exact = near & (exact == np.arange(len(exact))) & (h.item >= 0) & (h.level == 0)
        return np.where(is_exact, self.probability, np.where(known, np.maximum(tied, own), own))

    def best(self, order: Columns) -> int:
        """Of the ``order`` (C,) of the mappings by probability, the place of the one most probably right."""
        few = order[: min(len(order), CONSIDERED)]
        # One that is as good for nobody but whom it is best for may be last: it is right with that probability.
        right = np.array([max(float(self.good(self.squares[c]).sum()), float(self.scores[c])) for c in few])
        return int(few[int(np.argmax(right >= right.max() * (1.0 - SAME)))])


def infer_evidence(
    comparison: Comparison, assists: Sequence[Pair], askable: Sequence[int], answers: QuestionAnswers = NO_ANSWERS
) -> Prediction:
    """The mapping to carry out, and how probable it is that it is right."""
    config = comparison.config
    n, m = len(comparison.source), len(comparison.target)
    if not n or not m:
        return Prediction((UNMAPPED,) * n, 0.0, 0.0, next_row=askable[0] if askable else UNMAPPED)
    hypotheses = hypotheses_of(comparison)
    size = max(n, m)
    free = Posterior.of(hypotheses, AssistLikelihood.of(assists, size, m, config, answers))
    order = free.ranked()
    best = free.best(order)
    guess = free.squares[best]
    in_force = assists_in_force(assists, answers)
    obeying, obeying_score = guess, float(free.scores[best])
    if any(guess[row] != column for row, column in in_force):
        obeying, obeying_score = _obeying(free, comparison, in_force, answers)
    against = [pair for pair in in_force if guess[pair[0]] != pair[1] and pair not in answers.confirmed]
    doubts = {pair: 1.0 - float(free.share[pair]) for pair in against}
    doubted = max(doubts, key=lambda pair: doubts[pair], default=None)
    if doubted is not None and doubts[doubted] < config.doubt_at:
        doubted = None
    chosen, score = (guess, float(free.scores[best])) if doubted is not None else (obeying, obeying_score)
    good = free.good(chosen)
    question = best_question(free.share[:n, :m], askable, config)
    same = chosen is guess

    def real(square: Columns) -> tuple[int, ...]:
        return tuple(int(c) if c < m else UNMAPPED for c in square[:n])

    ranked = [int(c) for c in order[(free.squares[order] != chosen).any(axis=1)]]
    found = Prediction(
        columns=real(chosen),
        score=score,
        confidence=float(min(1.0, max(good.sum(), score))),
        winning=_heaviest(hypotheses, good),
        runner_up=_heaviest(hypotheses, np.maximum(free.probability - good, 0.0)),
        alternatives=tuple((real(free.squares[c]), float(free.scores[c])) for c in ranked[: config.max_alternatives]),
        ties=int((np.abs(free.scores - free.scores[best]) <= free.scores[best] * SAME).sum()) if same else 1,
        next_row=question.row,
        information_gain=question.gain,
        question_kind=question.kind,
        question_columns=question.columns,
        best_guess=Reading(real(guess), float(free.scores[best])),
        obeying=Reading(real(obeying), obeying_score),
    )
    if doubted is None:
        return found
    return replace(
        found,
        doubted=doubted,
        doubt=doubts[doubted],
        next_row=doubted[0],
        question_kind=QuestionKind.IS_THAT_SO,
        question_columns=(doubted[1],),
        information_gain=answer_gain(np.array([doubts[doubted], 1.0 - doubts[doubted]]), config.assist_error),
    )


def _obeying(
    free: Posterior, comparison: Comparison, in_force: Sequence[Pair], answers: QuestionAnswers
) -> tuple[Columns, float]:
    """The most probable mapping that holds every assist in force, and its probability when assists may be wrong."""
    size, m = free.squares.shape[1], len(comparison.target)
    certain = QuestionAnswers(frozenset(in_force), answers.denied)
    bound = Posterior.of(free.hypotheses, AssistLikelihood.of(in_force, size, m, comparison.config, certain))
    square = bound.squares[int(bound.ranked()[0])]
    return square, float(min(1.0, free.joint_of(square).sum()))


def _heaviest(hypotheses: Hypotheses, weights: Floats) -> tuple[int, ...]:
    """The feature set of greatest total weight (H,), () when none has any."""
    by_set = np.bincount(hypotheses.set_of, weights=weights, minlength=len(hypotheses.sets))
    by_set[0] = 0.0
    return hypotheses.sets[int(np.argmax(by_set))] if by_set.any() else ()
