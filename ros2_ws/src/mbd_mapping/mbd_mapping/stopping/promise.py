"""A promise in place of a threshold: the share of sessions in which going on alone must be right.

Stopping is calibrated by split conformal prediction on sessions (Vovk 2005; Angelopoulos and Bates 2021). A session is
wrong at threshold t when the robot, going on alone at the first state whose score reaches t, carries out a wrong
mapping. Its critical score is the greatest score of a state at which it would have stopped wrongly at some threshold:
above it no threshold does harm. With the critical scores of N calibration sessions, sorted, the threshold is the
ceil((N + 1) promise)-th: a new session exchangeable with those is then right with at least the promised probability,
whatever the scores are. What is new is not exchangeable: for a family of teachers that was not among those calibrated
on nothing is guaranteed, and docs/mapping.md shows what was found.

The score is the confidence corrected for how many objects are left to tell, which makes one threshold fair to all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class PromiseCalibration:
    """What a promise is kept by.

    Attributes:
        slope, per_left, offset: of the score: logit(score) = slope logit(confidence) + per_left log(1 + left) + offset.
        critical: critical scores at evenly spaced ranks, 0, 1/K, ..., 1 of the calibration sessions, rising.
        sessions: N, how many those were.
    """

    slope: float
    per_left: float
    offset: float
    critical: tuple[float, ...]
    sessions: int

    def score(self, confidence: float, left: int) -> float:
        """The corrected confidence with ``left`` objects nobody has told about."""
        z = self.slope * logit(confidence) + self.per_left * math.log1p(left) + self.offset
        return 1.0 / (1.0 + math.exp(-max(-500.0, min(500.0, z))))

    def critical_score(self, promise: float) -> float:
        """The score from which going on alone keeps the promise; more than 1 where N sessions cannot say so."""
        rank = math.ceil((self.sessions + 1) * promise) / self.sessions
        if rank > 1.0:
            return math.inf
        # Between two ranks kept, the higher one: never less than was found.
        return self.critical[math.ceil(rank * (len(self.critical) - 1) - 1e-9)]

    def threshold(self, promise: float, left: int) -> float:
        """The confidence from which the robot may go on alone with ``left`` objects left; more than 1: never."""
        wanted = self.critical_score(promise)
        if wanted >= 1.0:
            return 1.1
        z = (logit(wanted) - self.per_left * math.log1p(left) - self.offset) / self.slope
        return 1.0 / (1.0 + math.exp(-max(-500.0, min(500.0, z))))


def logit(probability: float) -> float:
    """Log odds, bounded for 0 and 1."""
    bounded = min(1.0 - 1e-9, max(1e-9, probability))
    return math.log(bounded / (1.0 - bounded))


def critical_of(scores: Sequence[float], right: Sequence[bool]) -> float:
    """The critical score of a session from its states in order; 0 when no threshold does harm.

    A state is stopped at, at some threshold, when no state before it scores as much.
    """
    greatest, critical = -1.0, 0.0
    for score, good in zip(scores, right, strict=True):
        if score > greatest:
            greatest = score
            if not good:
                critical = score
    return critical
