"""Teachers who weigh features: their scores, where shifts are among the features their scores by every likely shift.

Where a teacher goes by a shift, the shift is one more unknown: mapping and shift must be best for each other. It is
found by turns, the best mapping for a shift and the mean shift of that mapping, from several starts at once.
A mapping whose hue differences have no circular mean has no hue shift, and is not a teacher's who goes by one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd_mapping.assignment.assignment import Columns, best_assignment
from mbd_mapping.similarity import HUE_SHIFT, SIZE_SHIFT, Comparison, circular_mean
from mbd_mapping.tables import Floats

MAX_TURNS = 6
MAX_SHIFTS = 4
EXACT = 1e-9
FEW, MANY = 12, 40  # objects, up to which many or some starts are affordable


@dataclass(frozen=True)
class Scored:
    """What a teacher who goes by one weight vector may want.

    Attributes:
        score: (n, m) weighted mean similarity.
        columns: a best assignment of it, over the smaller side.
        value: its total.
    """

    score: Floats
    columns: Columns
    value: float


def smaller_side(score: Floats) -> Columns:
    """A best assignment of (n, m): the columns of the rows, or the rows of the columns when there are fewer of them."""
    return best_assignment(score if score.shape[0] <= score.shape[1] else score.T)


def scored(score: Floats) -> Scored:
    """A score with its best assignment."""
    columns = smaller_side(score)
    upright = score if score.shape[0] <= score.shape[1] else score.T
    return Scored(score, columns, float(upright[np.arange(len(columns)), columns].sum()))


class ShiftSearch:
    """The shifts of one comparison; what one weight vector finds is a start for the next.

    Args:
        comparison: n and m objects, both at least 1.
    """

    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison
        n, m = len(comparison.source), len(comparison.target)
        self._tall = n > m
        self.size = max(n, m)
        hue = comparison.target_hue[None, :] - comparison.source_hue[:, None]
        ratio = comparison.target.volume[None, :] / comparison.source.volume[:, None]
        self._hue, self._ratio = (hue.T, ratio.T) if self._tall else (hue, ratio)

    def starts(self) -> list[tuple[float, float]]:
        """(turn of the hue [deg], ratio of sizes) spread over the differences of all pairs."""
        limit = 24 if self.size <= FEW else 10 if self.size <= MANY else 4
        hue = np.sort((self._hue[~np.isnan(self._hue)]) % 360.0)
        hue = hue if hue.size else np.zeros(1)
        ratio = np.sort(self._ratio.ravel())
        count = min(limit, ratio.size)
        pick = (np.arange(count) + 0.5) / count
        return [(float(hue[int(p * hue.size)]), float(ratio[int(p * ratio.size)])) for p in pick]

    def solve(self, weights: Floats, starts: list[tuple[float, float]], keep: int) -> list[Scored]:
        """The self-consistent scores of ``weights`` (7,), best first, at most ``keep``; [] when there is none."""
        base = np.tensordot(weights, self._comparison.fixed, axes=1)
        found: dict[bytes, Scored] = {}
        seen: set[bytes] = set()
        for start in starts:
            hue, ratio = start
            for _ in range(MAX_TURNS):
                columns = smaller_side(self._with_shift(base, weights, hue, ratio))
                key = columns.tobytes()
                if key in seen:
                    break
                seen.add(key)
                mean = self._means(columns)
                if weights[HUE_SHIFT] and mean[0] is None:
                    break
                hue, ratio = mean[0] or 0.0, mean[1]
                score = self._with_shift(base, weights, hue, ratio)
                upright = score.T if self._tall else score
                found[key] = Scored(score, columns, float(upright[np.arange(len(columns)), columns].sum()))
        # What is not best for its own shift is no teacher's: it was a step on the way.
        best = sorted(found.values(), key=lambda item: -item.value)[: keep + 2]
        return sorted(map(_settled, best), key=lambda item: -item.value)[:keep]

    def shift_of(self, columns: Columns) -> tuple[float, float]:
        """(turn, ratio) of a mapping, 0 deg where it has none."""
        hue, ratio = self._means(columns)
        return hue or 0.0, ratio

    def _means(self, columns: Columns) -> tuple[float | None, float]:
        rows = np.arange(len(columns))
        return circular_mean(self._hue[rows, columns]), float(self._ratio[rows, columns].mean())

    def _with_shift(self, base: Floats, weights: Floats, hue: float, ratio: float) -> Floats:
        score = base
        if weights[HUE_SHIFT]:
            score = score + weights[HUE_SHIFT] * self._comparison.hue_shift_layer(hue)
        if weights[SIZE_SHIFT]:
            score = score + weights[SIZE_SHIFT] * self._comparison.size_shift_layer(ratio)
        return score


def _settled(item: Scored) -> Scored:
    """The same score with its best assignment, which may be another than the one whose shift it has."""
    return scored(item.score)
