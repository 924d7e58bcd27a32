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


def entropy(shares: Floats) -> float:
    """Entropy [bit] of a distribution (m,)."""
    positive = shares[shares > 0]
    return float(-(positive * np.log2(positive)).sum())


def answer_gain(known: Floats, error: float) -> float:
    """Expected information [bit] of an answer that names which of the cases (a,), of these probabilities, holds."""
    count = len(known)
    if count < 2:
        return 0.0
    wrong = error / (count - 1)
    noise = np.full(count, wrong)
    noise[0] = 1.0 - error
    answer = known * (1.0 - error) + (1.0 - known) * wrong
    return max(0.0, entropy(answer / answer.sum()) - entropy(noise / noise.sum()))


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
    m, error = share.shape[1], config.assist_error
    for row in askable:
        mass = float(share[row].sum())
        known = share[row] / mass if mass > 0 else np.full(m, 1.0 / m)
        if QuestionKind.WHAT_NEXT in config.question_kinds:
            yield Question(QuestionKind.WHAT_NEXT, row, (), answer_gain(known, error), config.open_cost)
        likely = np.argsort(-known, kind="stable")[:3]
        if QuestionKind.IS_THIS_IT in config.question_kinds:
            # The nearer to even, the more a yes or no tells: that is the likeliest column, or the one after it.
            for column in likely[:2]:
                gain = answer_gain(np.array([known[column], 1.0 - known[column]]), error)
                yield Question(QuestionKind.IS_THIS_IT, row, (int(column),), gain, config.yes_no_cost)
        if QuestionKind.WHICH_OF_TWO in config.question_kinds and m > 2:
            first, second = (int(c) for c in likely[:2])
            cases = np.array([known[first], known[second], max(0.0, 1.0 - known[first] - known[second])])
            gain = answer_gain(cases, error)
            yield Question(QuestionKind.WHICH_OF_TWO, row, (first, second), gain, config.which_of_two_cost)
