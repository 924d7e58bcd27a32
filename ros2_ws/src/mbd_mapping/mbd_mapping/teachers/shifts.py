"""Teachers who weigh features: their scores, where shifts are among the features their scores by every likely shift.

Where a teacher goes by a shift, the shift is one more unknown: mapping and shift must be best for each other. It is
found by turns, the best mapping for a shift and the mean shift of that mapping, from several starts at once.
A mapping whose hue differences have no circular mean has no hue shift, and is not a teacher's who goes by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbd_mapping.assignment.assignment import Columns, best_assignment, total
from mbd_mapping.similarity import HUE_SHIFT, SIZE_SHIFT, Comparison, circular_means
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
    return Scored(score, columns, total(upright, columns))


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
        limit = 14 if self.size <= FEW else 10 if self.size <= MANY else 4
        hue = np.sort((self._hue[~np.isnan(self._hue)]) % 360.0)
        hue = hue if hue.size else np.zeros(1)
        ratio = np.sort(self._ratio.ravel())
        count = min(limit, ratio.size)
        pick = (np.arange(count) + 0.5) / count
        return [(float(hue[int(p * hue.size)]), float(ratio[int(p * ratio.size)])) for p in pick]

    def solve(self, weights: Floats, starts: Sequence[tuple[float, float]], keep: int) -> list[list[Scored]]:
        """For each of ``weights`` (V, 7) its self-consistent scores, best first, at most ``keep``; [] where none is.

        All vectors and starts take their turns together.
        """
        base = np.tensordot(weights, self._comparison.fixed, axes=1)
        vector, hue, ratio = _distinct(weights, starts)
        found: list[list[tuple[bool, Scored]]] = [[] for _ in weights]
        seen: set[tuple[int, bytes]] = set()
        columns = [smaller_side(score) for score in self._scores(base, weights, vector, hue, ratio)]
        for _ in range(MAX_TURNS):
            fresh = []
            for place, (v, chosen) in enumerate(zip(vector.tolist(), columns, strict=True)):
                key = v, chosen.tobytes()
                if key not in seen:
                    seen.add(key)
                    fresh.append(place)
            if not fresh:
                break
            chosen_now = np.array([columns[place] for place in fresh])
            vector = vector[fresh]
            hue, ratio = self._means(chosen_now)
            exists = ~np.isnan(hue) | (weights[vector, HUE_SHIFT] == 0)
            vector, chosen_now = vector[exists], chosen_now[exists]
            hue, ratio = np.nan_to_num(hue[exists]), ratio[exists]
            if not len(vector):
                break
            scores = self._scores(base, weights, vector, hue, ratio)
            columns = [smaller_side(score) for score in scores]
            values, own = self._values(scores, np.array(columns)), self._values(scores, chosen_now)
            moves_on = own < values - EXACT
            for place, v in enumerate(vector.tolist()):
                item = Scored(scores[place], columns[place], float(values[place]))
                found[v].append((bool(moves_on[place]), item))
        return [_best(items, keep) for items in found]

    def shift_of(self, columns: Columns) -> tuple[float, float]:
        """(turn, ratio) of a mapping, 0 deg where it has none."""
        hue, ratio = self._means(columns[None])
        return float(np.nan_to_num(hue[0])), float(ratio[0])

    def _means(self, columns: Columns) -> tuple[Floats, Floats]:
        """((S,) circular mean of the hue differences, NaN where it does not exist, (S,) mean ratio) of each mapping."""
        rows = np.arange(columns.shape[1])
        return circular_means(self._hue[rows, columns]), self._ratio[rows, columns].mean(axis=1)

    def _values(self, scores: Floats, columns: Columns) -> Floats:
        """(S,) totals of the mappings (S, N), over the smaller side, by the scores (S, n, m)."""
        upright = scores.transpose(0, 2, 1) if self._tall else scores
        totals: Floats = np.take_along_axis(upright, columns.reshape(*upright.shape[:2], 1), axis=2).sum(axis=(1, 2))
        return totals

    def _scores(self, base: Floats, weights: Floats, vector: Columns, hue: Floats, ratio: Floats) -> Floats:
        """(S, n, m) scores of the vectors (S,) by their shifts (S,)."""
        of_hue = weights[vector, HUE_SHIFT][:, None, None] * self._comparison.hue_shift_layer(hue[:, None, None])
        of_size = weights[vector, SIZE_SHIFT][:, None, None] * self._comparison.size_shift_layer(ratio[:, None, None])
        scores: Floats = base[vector] + of_hue + of_size
        return scores


def _distinct(weights: Floats, starts: Sequence[tuple[float, float]]) -> tuple[Columns, Floats, Floats]:
    """(vector, turn, ratio) of each start of each of ``weights`` (V, 7), those left out that only repeat another."""
    vector = np.repeat(np.arange(len(weights)), len(starts))
    shift = np.tile(np.array(starts, dtype=float).reshape(-1, 2), (len(weights), 1))
    shift = np.where(weights[vector][:, [HUE_SHIFT, SIZE_SHIFT]] > 0, shift, 0.0)
    first = np.sort(np.unique(np.column_stack([vector, shift]), axis=0, return_index=True)[1])
    return vector[first], shift[first, 0], shift[first, 1]


def _best(items: list[tuple[bool, Scored]], keep: int) -> list[Scored]:
    """The best of those whose mapping and shift are best for each other; of all, should none be."""
    settled = [item for moves_on, item in items if not moves_on] or [item for _, item in items]
    return sorted(settled, key=lambda item: -item.value)[:keep]
