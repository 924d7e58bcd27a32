"""Which object seen is which of those believed there: the assignment whose log-odds sum up highest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.objects import SceneObject
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mbd_execution.looking.expected import Expected
from mbd_execution.looking.likeness import fallen_log_odds, log_odds

# Log-probabilities: that one which should show is gone, that one which need not show does not, that there is a new one.
GONE, NOT_SHOWN, NEW = -4.0, -0.7, -3.5
NEVER = -1e6


@dataclass(frozen=True)
class Identity:
    """What became of one expected object.

    Attributes:
        expected: which.
        seen: index of the object seen that it is; None: it is not seen.
        fallen: it lies on its side now.
        margin: [nats] by how much the best assignment that gives this object another place is worse.
        otherwise: index it has in that assignment.
        piled: it is there, seen as one with what it stands on or what stands on it, moved by this (x, y) [m].
    """

    expected: Expected
    seen: int | None
    fallen: bool = False
    margin: float = np.inf
    otherwise: int | None = None
    piled: tuple[float, float] | None = None


@dataclass(frozen=True)
class Identities:
    """What became of all of them.

    Attributes:
        known: of each expected object, in order.
        new: indices of objects seen that are none of them.
        total: [nats] log-probability of all this, up to what is the same for every look at as many objects.
    """

    known: tuple[Identity, ...]
    new: tuple[int, ...]
    total: float = 0.0

    def __getitem__(self, object_id: str) -> Identity:
        """Of the object of that id; raises KeyError when it was not expected."""
        for identity in self.known:
            if identity.expected.object.object_id == object_id:
                return identity
        raise KeyError(object_id)


def identify(expected: Sequence[Expected], seen: Sequence[SceneObject]) -> Identities:
    """The most probable assignment.

    Args:
        expected: what should show.
        seen: the objects of the look, ``centroid`` the middle of their boxes.
    """
    if not expected:
        return Identities((), tuple(range(len(seen))))
    upright: NDArray[np.float64] = np.array([[log_odds(e, s) for s in seen] for e in expected])
    lying = np.array([[fallen_log_odds(e, s) for s in seen] for e in expected])
    upright, lying = upright.reshape(len(expected), len(seen)), lying.reshape(len(expected), len(seen))
    score = np.maximum(upright, lying) - NEW
    unseen = np.array([NOT_SHOWN if e.hidden else GONE for e in expected])
    best, total = _assigned(score, unseen)
    known = []
    for row, column in enumerate(best):
        other = score.copy()
        absent = unseen.copy()
        if column is None:
            absent[row] = NEVER
        else:
            other[row, column] = NEVER
        second, worse = _assigned(other, absent)
        fallen = column is not None and bool(lying[row, column] > upright[row, column])
        known.append(Identity(expected[row], column, fallen, total - worse, second[row]))
    return Identities(tuple(known), tuple(i for i in range(len(seen)) if i not in best), total)


def _assigned(
    score: NDArray[np.float64], unseen: NDArray[np.float64]
) -> tuple[list[int | None], float]:  # fmt: skip
    """(index seen or None of each row, sum of the scores) of the best assignment; a row may stay without."""
    rows, columns = score.shape
    complete = np.full((rows, columns + rows), NEVER)
    complete[:, :columns] = score
    complete[np.arange(rows), columns + np.arange(rows)] = unseen
    chosen = linear_sum_assignment(complete, maximize=True)[1]
    return [int(c) if c < columns else None for c in chosen], float(complete[np.arange(rows), chosen].sum())
