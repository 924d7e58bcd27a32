"""How far two annotators agree: Cohen's kappa over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from mbd_study.annotation.intervals import Interval

NOTHING = "-"


@dataclass(frozen=True)
class Agreement:
    """Of two annotators about one tier.

    Attributes:
        seconds: how long one gave a label and the other another, by (label of one, label of the other); `NOTHING`
            where one gave none.
        observed: share of the time in which both labels are equal.
        expected: the same if they labelled by chance, each as often as they do.
        kappa: (observed - expected) / (1 - expected); None when both give one and the same label throughout.
    """

    seconds: Mapping[tuple[str, str], float]
    observed: float
    expected: float
    kappa: float | None


def agreement(one: Sequence[Interval], other: Sequence[Interval], duration: float) -> Agreement:
    """Cohen's kappa, weighted by time instead of counted by sample: no length of a sample has to be chosen.

    Args:
        one: intervals of one annotator's tier; where two overlap the later one counts.
        other: of the other's.
        duration: of the time compared, from 0 [s]; what is not annotated has the label `NOTHING`.

    Raises:
        ValueError: the duration is not positive.

    References:
        Cohen, J. (1960): A coefficient of agreement for nominal scales. Educational and Psychological Measurement 20,
        37-46.
    """
    if duration <= 0:
        raise ValueError(f"the duration is {duration} s; expected more than 0")
    cuts = {0.0, duration}
    cuts |= {min(max(t, 0.0), duration) for i in (*one, *other) for t in (i.start, i.end)}
    seconds: dict[tuple[str, str], float] = {}
    for start, end in pairwise(sorted(cuts)):
        pair = (_label_at(one, start), _label_at(other, start))
        seconds[pair] = seconds.get(pair, 0.0) + end - start
    labels = sorted({label for pair in seconds for label in pair})
    share = {
        label: [sum(s for pair, s in seconds.items() if pair[who] == label) / duration for who in (0, 1)]
        for label in labels
    }
    observed = sum(s for (a, b), s in seconds.items() if a == b) / duration
    expected = sum(a * b for a, b in share.values())
    kappa = None if len(labels) == 1 else (observed - expected) / (1.0 - expected)
    return Agreement(seconds, observed, expected, kappa)


def _label_at(intervals: Sequence[Interval], time: float) -> str:
    covering = [i for i in intervals if i.start <= time < i.end]
    return max(covering, key=lambda i: i.start).label or NOTHING if covering else NOTHING
