"""Which one question would teach most about the mapping, for a second of the teacher's time.

The answer to a question about row i depends on the mapping through that row's column only, so what it is expected to
tell about the mapping is the entropy of the answer less the entropy of the answer's own errors (Lindley 1956). Three
kinds compete by that gain over their cost: the open one, yes or no about one column, and which of two columns, or
neither. An answer is wrong as rarely as an assist; a wrong one is any other answer, all alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.estimate import QuestionKind

from mbd_mapping.config import MappingConfig
from mbd_mapping.strategy import UNMAPPED
from mbd_mapping.tables import Floats

SAME = 1e-9


@dataclass(frozen=True)
class Question:
    """A question and what it is worth.

    Attributes:
        kind: how it is asked.
        row: about which source row; UNMAPPED when there is nothing to ask.
        columns: the target columns it names: none, one or two.
        gain: expected information about the mapping [bit].
        cost: of the teacher's time [s].
    """

    kind: QuestionKind = QuestionKind.WHAT_NEXT
    row: int = UNMAPPED
    columns: tuple[int, ...] = ()
    gain: float = 0.0
    cost: float = 1.0

    @property
    def rate(self) -> float:
        """Expected information for its time [bit/s]."""
        return self.gain / self.cost


def entropies(shares: Floats) -> Floats:
    """(...,) entropies [bit] of distributions (..., m)."""
    logs = np.log2(shares, out=np.zeros_like(shares), where=shares > 0)
    found: Floats = -(shares * logs).sum(axis=-1)
    return found


def answer_gains(known: Floats, error: float) -> Floats:
    """(Q,) expected information [bit] of answers that name which of the cases, of these probabilities (Q, a), holds."""
    count = known.shape[1]
    if count < 2:
        return np.zeros(len(known))
    wrong = error / (count - 1)
    noise = np.full(count, wrong)
    noise[0] = 1.0 - error
    answer = known * (1.0 - error) + (1.0 - known) * wrong
    answer = answer / answer.sum(axis=1, keepdims=True)
    gains: Floats = np.maximum(0.0, entropies(answer) - entropies(noise / noise.sum()))
    return gains


def answer_gain(known: Floats, error: float) -> float:
    """The same of one answer, cases (a,)."""
    return float(answer_gains(known[None], error)[0])


def best_question(share: Floats, askable: Sequence[int], config: MappingConfig) -> Question:
    """The question of greatest gain for its cost; the first in task order, and the open one, among equals.

    Args:
        share: (n, m) posterior probability that row i goes to column j.
        askable: rows that may be asked about, in task order.
        config: the probability of a wrong answer, the kinds of question that may be asked, and what each costs.
    """
    best = Question()
    for question in _questions(share, askable, config):
        if best.row == UNMAPPED or question.rate > best.rate + SAME:
            best = question
    return best


def _questions(share: Floats, askable: Sequence[int], config: MappingConfig) -> Iterator[Question]:
    m, error, kinds = share.shape[1], config.assist_error, config.question_kinds
    if not askable:
        return
    asked = share[list(askable)]
    mass = asked.sum(axis=1, keepdims=True)
    known = np.where(mass > 0, asked / np.where(mass > 0, mass, 1.0), 1.0 / m)
    likely = np.argsort(-known, axis=1, kind="stable")[:, :2]
    first, second = known[np.arange(len(known)), likely[:, 0]], known[np.arange(len(known)), likely[:, -1]]
    # The nearer to even, the more a yes or no tells: that is the likeliest column, or the one after it.
    of_columns = [answer_gains(np.stack([p, 1.0 - p], axis=1), error) for p in (first, second)[: likely.shape[1]]]
    of_all = answer_gains(known, error)
    of_two = answer_gains(np.stack([first, second, np.maximum(0.0, 1.0 - first - second)], axis=1), error)
    for place, row in enumerate(askable):
        columns = tuple(int(c) for c in likely[place])
        if QuestionKind.WHAT_NEXT in kinds:
            yield Question(QuestionKind.WHAT_NEXT, row, (), float(of_all[place]), config.open_cost)
        if QuestionKind.IS_THIS_IT in kinds:
            for column, gain in zip(columns, of_columns, strict=True):
                yield Question(QuestionKind.IS_THIS_IT, row, (column,), float(gain[place]), config.yes_no_cost)
        if QuestionKind.WHICH_OF_TWO in kinds and m > 2:
            yield Question(QuestionKind.WHICH_OF_TWO, row, columns, float(of_two[place]), config.which_of_two_cost)
