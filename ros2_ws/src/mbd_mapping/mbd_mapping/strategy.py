"""What a strategy is given and what it gives back: rows and columns, no names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from mbd_model.estimate import QuestionKind

from mbd_mapping.similarity import Comparison

UNMAPPED = -1
Pair = tuple[int, int]


@dataclass(frozen=True)
class QuestionAnswers:
    """What the teacher said besides the assists.

    Attributes:
        confirmed: assists that the teacher was asked about and said yes to: they are certain.
        denied: (source row, target column) pairs that the teacher said are none.
        doubts: of an assist given for a demonstrated step that may have been about another object: probability of that.
    """

    confirmed: frozenset[Pair] = frozenset()
    denied: tuple[Pair, ...] = ()
    doubts: tuple[tuple[Pair, float], ...] = ()


NO_ANSWERS = QuestionAnswers()


@dataclass(frozen=True)
class Reading:
    """A mapping with what the strategy gives it.

    Attributes:
        columns: (n,) target column of each source row, UNMAPPED where there is none.
        score: its probability for "evidence".
    """

    columns: tuple[int, ...]
    score: float


@dataclass(frozen=True)
class Prediction:
    """One inference over n source rows and m target columns.

    Attributes:
        columns: (n,) target column of each source row, UNMAPPED where there is none.
        score: what the strategy gives that mapping.
        confidence: 0..1.
        winning, runner_up: feature indices of alpha and beta, () when there is none.
        alternatives: other mappings and their scores, best first.
        ties: how many mappings share the best score, capped by ``config.max_ties``.
        next_row: source row whose assist would teach most, UNMAPPED when nothing is left to ask.
        information_gain: what that assist is expected to teach [bit].
        question_kind, question_columns: how to ask about it, and the columns the question names.
        best_guess: the most probable mapping when any unconfirmed assist may be wrong; None: the prediction.
        obeying: the most probable mapping that holds every assist in force; None: the prediction.
        doubted: the assist to ask about first; None when none is doubted.
        doubt: probability that it is wrong.
    """

    columns: tuple[int, ...]
    score: float
    confidence: float
    winning: tuple[int, ...] = ()
    runner_up: tuple[int, ...] = ()
    alternatives: tuple[tuple[tuple[int, ...], float], ...] = ()
    ties: int = 1
    next_row: int = UNMAPPED
    information_gain: float = 0.0
    question_kind: QuestionKind = QuestionKind.WHAT_NEXT
    question_columns: tuple[int, ...] = ()
    best_guess: Reading | None = None
    obeying: Reading | None = None
    doubted: Pair | None = None
    doubt: float = 0.0


class Strategy(Protocol):
    """A way of inferring the mapping; a pure function of its arguments."""

    def __call__(
        self,
        comparison: Comparison,
        assists: Sequence[Pair],
        askable: Sequence[int],
        answers: QuestionAnswers = NO_ANSWERS,
    ) -> Prediction:
        """Infer from the assists as (source row, target column), oldest first, contradictions included.

        ``askable`` are the source rows the robot may still ask about, in task order; ``answers`` what else was said.
        """
        ...


def first_assists(assists: Sequence[Pair]) -> tuple[Pair, ...]:
    """The assists left when one for a row already assisted, or a column already taken, changes nothing."""
    kept: list[Pair] = []
    for row, column in assists:
        if all(row != r and column != c for r, c in kept):
            kept.append((row, column))
    return tuple(kept)


def assists_in_force(assists: Sequence[Pair], answers: QuestionAnswers = NO_ANSWERS) -> tuple[Pair, ...]:
    """The assists left when a later one takes the place of an earlier one for the same row or column.

    None takes the place of one that is confirmed but another that is confirmed.
    """
    kept: list[Pair] = []
    distinct = list(dict.fromkeys(reversed(assists)))
    for row, column in sorted(distinct, key=lambda pair: pair not in answers.confirmed):
        if all(row != r and column != c for r, c in kept):
            kept.append((row, column))
    return tuple(kept)
