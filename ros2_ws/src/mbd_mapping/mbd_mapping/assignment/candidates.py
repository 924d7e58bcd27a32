"""The few mappings among which the most probable one is looked for.

The mapping that most hypotheses of one mapping agree on; the mappings that are best for hypotheses of several; and of
each of those the one that the others believe most. Rows or columns of nothing are interchangeable, so the search goes
over the real objects: what it costs to leave a column to nothing is taken off what it scores to use it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from mbd_mapping.assignment.assignment import Columns, Detours, best_assignment
from mbd_mapping.assignment.ties import optimal_assignments
from mbd_mapping.tables import Floats
from mbd_mapping.teachers.assist_likelihood import AssistLikelihood
from mbd_mapping.teachers.hypotheses import Hypotheses

AGREED = 24
LIKELIEST = 12
TIED_HYPOTHESES = 4
MAX_TIED = 24
SAME = 1e-9
FORBIDDEN = -1e6
WORTH_NAMING = 1e-3  # probability of a hypothesis whose best mapping is an alternative worth naming


def agreed(hypotheses: Hypotheses, posterior: Floats) -> tuple[Columns, Floats, bool]:
    """What the hypotheses of one mapping agree on.

    Returns:
        Their different mappings (U, N), the probability of the hypotheses that hold each (U,), and whether one of them
        leads: has more than all hypotheses of several mappings together, so that no mapping of theirs alone can win.
    """
    mappings, place = hypotheses.distinct
    mass: Floats = np.bincount(place, weights=posterior[hypotheses.unique], minlength=len(mappings)).astype(float)
    return mappings, mass, bool(mass.max(initial=0.0) > posterior[~hypotheses.unique].sum() + SAME)


def candidates(
    hypotheses: Hypotheses, likelihoods: AssistLikelihood, posterior: Floats, share: Floats | None
) -> Columns:
    """(C, N) square mappings, each another real one.

    Args:
        hypotheses: about the teacher.
        likelihoods: of the assists.
        posterior: (H,) probability of each hypothesis.
        share: (N, N) probability of each pair; not needed where one mapping leads.
    """
    found: dict[bytes, Columns] = {}
    for square in _found(hypotheses, likelihoods, posterior, share):
        real = np.where(square < hypotheses.targets, square, -1)[: hypotheses.sources]
        found.setdefault(real.tobytes(), square)
    return np.array(list(found.values()))


def _found(
    hypotheses: Hypotheses, likelihoods: AssistLikelihood, posterior: Floats, share: Floats | None
) -> Iterator[Columns]:
    mappings, mass, leads = agreed(hypotheses, posterior)
    yield from mappings[np.argsort(-mass, kind="stable")[:AGREED]]
    several = np.flatnonzero(~hypotheses.unique)
    several = several[np.argsort(-posterior[several], kind="stable")[:LIKELIEST]]
    log_likelihood = _log(likelihoods.likelihood)
    for rank, h in enumerate(several):
        if posterior[h] < WORTH_NAMING and (leads or rank):
            break
        weights = _log(hypotheses.weights[h])
        score = _real(weights + log_likelihood, hypotheses)
        best = best_assignment(score)
        yield _square(best, hypotheses)
        if leads or share is None:
            continue
        if rank < TIED_HYPOTHESES:
            tied = optimal_assignments(Detours.around(score, best), SAME)
            yield from (_square(columns, hypotheses) for columns in itertools.islice(tied, MAX_TIED))
        yield _square(best_assignment(_real(weights + _log(share), hypotheses)), hypotheses)


def _log(values: Floats) -> Floats:
    """Logarithm, FORBIDDEN where there is none."""
    logs: Floats = np.log(values, out=np.full(values.shape, FORBIDDEN), where=values > 0)
    return logs


def _real(score: Floats, hypotheses: Hypotheses) -> Floats:
    """Score over real objects, the smaller side as rows, from one over squares (N, N)."""
    n, m = hypotheses.sources, hypotheses.targets
    real: Floats = score
    if n < m:
        real = score[:n] - score[n]
    elif n > m:
        real = (score[:, :m] - score[:, m][:, None]).T
    return real


def _square(columns: Columns, hypotheses: Hypotheses) -> Columns:
    """A square mapping from one over the smaller side: what is left goes to nothing in order."""
    if hypotheses.sources == hypotheses.targets:
        return columns
    left = np.setdiff1d(np.arange(max(hypotheses.sources, hypotheses.targets)), columns)
    whole = np.concatenate([columns, left])
    return np.argsort(whole) if hypotheses.sources > hypotheses.targets else whole
