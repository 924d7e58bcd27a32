"""Strategy "evidence": weigh every feature set by how well its own best mappings explain all assists.

The posterior over mappings is exact for the model of ``teachers`` and ``claims`` (up to the size where ``permanent``
approximates): P(m | A) = sum_h P(h) P(m | h) P(A | m) / P(A). An assist that is wrong costs its hypothesis a factor;
none is ever excluded. The confidence is the posterior probability that the mapping is right: that it is the teacher's,
or as good for what the teacher goes by.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbd_mapping.assignment.candidates import SAME, agreed, candidates
from mbd_mapping.assist_likelihood import AssistLikelihood
from mbd_mapping.hypotheses import EXACT, Hypotheses, hypotheses_of
from mbd_mapping.question import best_question
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import UNMAPPED, Pair, Prediction
from mbd_mapping.tables import Floats


def infer_evidence(comparison: Comparison, assists: Sequence[Pair], askable: Sequence[int]) -> Prediction:
    """The mapping of most posterior probability, and how probable it is that it is right."""
    config = comparison.config
    n, m = len(comparison.source), len(comparison.target)
    if not n or not m:
        return Prediction((UNMAPPED,) * n, 0.0, 0.0, next_row=askable[0] if askable else UNMAPPED)
    hypotheses = hypotheses_of(comparison)
    size = hypotheses.slack.shape[1]
    likelihoods = AssistLikelihood.of(assists, size, m, config)
    log_joint = hypotheses.log_prior + likelihoods.of_hypotheses(hypotheses)
    evidence = np.logaddexp.reduce(log_joint)
    posterior = np.exp(log_joint - evidence)

    leads = agreed(hypotheses, posterior)[2]
    share = None if leads and not askable else np.einsum("h,hij->ij", posterior, likelihoods.marginals(hypotheses))
    squares = candidates(hypotheses, likelihoods, posterior, share)
    mappings = [tuple(int(c) if c < m else UNMAPPED for c in square[:n]) for square in squares]
    gaps = hypotheses.slack[:, np.arange(size), squares].sum(axis=2)
    prior = np.exp(hypotheses.log_prior[:, None] - evidence) * hypotheses.weights[:, np.arange(size), squares].prod(
        axis=2
    )
    shares = prior * likelihoods.of_mappings(squares) * hypotheses.copies
    scores = np.minimum(1.0, shares.sum(axis=0))
    order = np.argsort(-scores, kind="stable")
    best = int(order[0])

    # As good for what the teacher goes by: no gap in what is exact, and one within the noise where there is noise.
    good = (gaps[:, best] <= np.where(hypotheses.noise == 0, EXACT, 2 * config.similarity_noise)) & np.isfinite(
        hypotheses.noise
    )
    confidence = float(np.where(good, posterior, shares[:, best]).sum())
    next_row, gain = UNMAPPED, 0.0
    if askable and share is not None:
        next_row, gain = best_question(share[:n, :m], askable, config)
    ranked = order[1 : 1 + config.max_alternatives]
    return Prediction(
        columns=mappings[best],
        score=float(scores[best]),
        confidence=min(1.0, confidence),
        winning=_heaviest(hypotheses, shares[:, best]),
        runner_up=_heaviest(hypotheses, np.where(good, 0.0, posterior)),
        alternatives=tuple((mappings[int(c)], float(scores[c])) for c in ranked),
        ties=int((scores >= scores[best] * (1.0 - SAME)).sum()),
        next_row=next_row,
        information_gain=gain,
    )


def _heaviest(hypotheses: Hypotheses, weights: Floats) -> tuple[int, ...]:
    """The feature set of greatest total weight (H,), () when none has any."""
    by_set = np.bincount(hypotheses.set_of, weights=weights, minlength=len(hypotheses.sets))
    by_set[0] = 0.0
    return hypotheses.sets[int(np.argmax(by_set))] if by_set.any() else ()
