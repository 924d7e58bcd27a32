"""Pieces of one thing that is cut in two by what stands before it, joined by a logistic model of their features."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mbd_perception.segmentation.joining import rejoin_weights
from mbd_perception.segmentation.joining.occlusion import PieceFeatures, Pieces

# What the model is given of a pair, in this order.
TERMS = ("misfit", "breadth", "top", "open_way", "chroma")


def model_row(features: PieceFeatures) -> tuple[float, ...]:
    """``TERMS``: misfit; 1 - breadth; top; the way that is not hidden plus that with the table; chroma / 30."""
    return (
        features.misfit,
        1.0 - features.breadth,
        features.top,
        1.0 - features.hidden + features.table,
        features.chroma / 30.0,
    )


@dataclass(frozen=True)
class RejoinConfig:
    """Log-odds that two pieces are one thing cut in two by what stands before them: a logistic model.

    `train_rejoin` fits it again, to frames that perception may be chosen by and to rendered rooms.

    Attributes:
        bias: when all of ``TERMS`` are 0.
        weights: of ``TERMS``.
    """

    bias: float = rejoin_weights.BIAS
    weights: tuple[float, ...] = (
        rejoin_weights.MISFIT,
        rejoin_weights.BREADTH,
        rejoin_weights.TOP,
        rejoin_weights.OPEN_WAY,
        rejoin_weights.CHROMA,
    )

    def log_odds(self, features: PieceFeatures) -> float:
        """Above 0 they are rather one."""
        return self.bias + sum(w * value for w, value in zip(self.weights, model_row(features), strict=True))


def rejoined(pieces: Pieces, config: RejoinConfig) -> NDArray[np.int32]:
    """(count + 1,) group of each region after pieces of one thing have been joined, the surest pair first."""
    groups = pieces.groups.copy()
    scored = []
    for a, b in pieces.candidates():
        # A better fit speaks for one thing, so that most pairs are decided without it.
        outlines = pieces.compare_outlines(a, b)
        if config.weights[0] > 0 or config.log_odds(outlines) > 0.0:
            scored.append((config.log_odds(replace(outlines, misfit=pieces.misfit(a, b))), a, b))
    for odds, a, b in sorted(scored, reverse=True):
        if odds <= 0.0:
            break
        first, second = sorted((int(groups[a]), int(groups[b])))
        groups[groups == second] = first
    return groups
