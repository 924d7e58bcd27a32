"""A lesson played through: what a strategy says after each assist, and what it asks about at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import STRATEGIES
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import Pair, Prediction, QuestionAnswers

from mbd_experiments.teacher_families.lesson import Lesson


@dataclass(frozen=True)
class Said:
    """What a strategy said after some assists.

    Attributes:
        assists: how many.
        left: how many correspondences nobody had told yet.
        confidence: of its mapping.
        right: whether the mapping was the teacher's or as good.
        solved: whether it was the only one predicted, and the teacher's.
        best_guess_right: whether its best guess was.
        doubts: whether it would ask about an assist first.
    """

    assists: int
    left: int
    confidence: float
    right: bool
    solved: bool
    best_guess_right: bool
    doubts: bool


@dataclass(frozen=True)
class LessonEnd:
    """How a lesson ends when all is told and the teacher answers questions about it.

    Attributes:
        questions: how many assists were asked about.
        as_meant: whether the mapping ended as the teacher means it.
    """

    questions: int
    as_meant: bool


def listen(lesson: Lesson, config: MappingConfig, counts: Sequence[int] | None = None) -> list[Said]:
    """What the strategy says after each number of assists, or after these."""
    comparison = Comparison.of(lesson.source, lesson.target, config)
    infer = STRATEGIES[config.strategy]
    mapped = sum(column >= 0 for column in lesson.columns)
    found = []
    for k in range(len(lesson.assists) + 1):
        if counts is not None and k not in counts:
            continue
        said = infer(comparison, lesson.assists[:k], ())
        guess = said.best_guess.columns if said.best_guess else said.columns
        found.append(
            Said(
                k,
                mapped - k,
                said.confidence,
                lesson.is_right(said.columns),
                said.ties == 1 and said.columns == lesson.columns,
                lesson.is_right(guess),
                said.doubted is not None,
            )
        )
    return found


def finish(lesson: Lesson, config: MappingConfig) -> LessonEnd:
    """All assists are given; the robot asks about those it doubts, and the teacher answers what was meant.

    Asked about a right assist the teacher says yes; about a wrong one the teacher gives the right one, and, as people
    do who notice that they gave two for each other, says so of the other one too when it is asked about.
    """
    comparison = Comparison.of(lesson.source, lesson.target, config)
    infer = STRATEGIES[config.strategy]
    assists: list[Pair] = list(lesson.assists)
    confirmed: set[Pair] = set()
    denied: list[Pair] = []
    questions = 0
    said: Prediction = infer(comparison, assists, ())
    while said.doubted is not None and questions <= 2 * len(assists):
        questions += 1
        row, column = said.doubted
        meant = row, lesson.columns[row]
        if meant != (row, column):
            assists = [pair for pair in assists if pair != (row, column)]
            denied.append((row, column))
            assists.append(meant)
        confirmed.add(meant)
        said = infer(comparison, assists, (), QuestionAnswers(frozenset(confirmed), tuple(denied)))
    return LessonEnd(questions, lesson.is_right(said.columns))
