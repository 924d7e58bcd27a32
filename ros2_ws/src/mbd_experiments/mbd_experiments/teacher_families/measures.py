"""Figures of many lessons of one family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbd_experiments.teacher_families.playing import LessonEnd, Said

SURE = 0.9
BINS = 10


@dataclass(frozen=True)
class Figures:
    """One family and strategy.

    Attributes:
        solved: share solved after 0, 1, ... assists, as far as every lesson goes.
        calibration_error: expected calibration error over k = 0..n-1, ten equal bins.
        sure_right, sure_share: share right where it is surer than SURE, NaN where it never is; how often it is.
        guess_right: share of the best guesses right when all assists are given.
        questions: asked about assists, a session, when all is told.
        as_meant: share of the sessions that then end as meant.
    """

    solved: tuple[float, ...]
    calibration_error: float
    sure_right: float
    sure_share: float
    guess_right: float
    questions: float
    as_meant: float


def calibration_error(said: Sequence[Said]) -> float:
    """Mean distance of confidence and share right over equal bins of confidence."""
    confidence = np.array([s.confidence for s in said])
    right = np.array([s.right for s in said], dtype=float)
    place = np.minimum((confidence * BINS).astype(int), BINS - 1)
    return float(np.abs(np.bincount(place, weights=confidence - right, minlength=BINS)).sum() / max(1, len(said)))


def figures(lessons: Sequence[Sequence[Said]], endings: Sequence[LessonEnd]) -> Figures:
    """Of all lessons of a family; the states in which nothing is left to tell are no test of calibration."""
    open_states = [s for lesson in lessons for s in lesson if s.left > 0]
    sure = [s for s in open_states if s.confidence >= SURE]
    counts = sorted({s.assists for lesson in lessons for s in lesson if s.left > 0})[:5]
    solved = [float(np.mean([s.right for lesson in lessons for s in lesson if s.assists == k])) for k in counts]
    return Figures(
        solved=tuple(solved),
        calibration_error=calibration_error(open_states),
        sure_right=float(np.mean([s.right for s in sure])) if sure else float("nan"),
        sure_share=len(sure) / max(1, len(open_states)),
        guess_right=float(np.mean([lesson[-1].best_guess_right for lesson in lessons])),
        questions=float(np.mean([e.questions for e in endings])) if endings else 0.0,
        as_meant=float(np.mean([e.as_meant for e in endings])) if endings else float("nan"),
    )
