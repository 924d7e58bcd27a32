"""What a strategy is given and what it gives back: rows and columns, no names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from mbd_mapping.similarity import Comparison

UNMAPPED = -1
Pair = tuple[int, int]


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


class Strategy(Protocol):
    """A way of inferring the mapping; a pure function of its arguments."""

    def __call__(self, comparison: Comparison, assists: Sequence[Pair], askable: Sequence[int]) -> Prediction:
        """Infer from the assists as (source row, target column), oldest first, contradictions included.

        ``askable`` are the source rows the robot may still ask about, in task order.
        """
        ...


def first_assists(assists: Sequence[Pair]) -> tuple[Pair, ...]:
    """The assists left when one for a row already assisted, or a column already taken, changes nothing."""
    kept: list[Pair] = []
    for row, column in assists:
        if all(row != r and column != c for r, c in kept):
            kept.append((row, column))
    return tuple(kept)
