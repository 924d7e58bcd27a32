"""Which one question would teach most about the mapping: expected information gain.

The answer to "which object plays the role of row i?" depends on the mapping through that row's column only, so what it
is expected to reveal about the mapping is the entropy of the answer less the entropy of the answer's own errors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbd_mapping.config import MappingConfig
from mbd_mapping.strategy import UNMAPPED
from mbd_mapping.tables import Floats

SAME = 1e-9


def entropy(shares: Floats) -> float:
    """Entropy [bit] of a distribution (m,)."""
    positive = shares[shares > 0]
    return float(-(positive * np.log2(positive)).sum())


def best_question(share: Floats, askable: Sequence[int], config: MappingConfig) -> tuple[int, float]:
    """(row, expected gain [bit]) of the question that teaches most; the first in task order among equals.

    Args:
        share: (n, m) posterior probability that row i goes to column j.
        askable: rows that may be asked about, in task order.
        config: the probability of a wrong answer.
    """
    m = share.shape[1]
    wrong = config.assist_error / max(1, m - 1)
    noise = np.full(m, wrong)
    noise[:1] = 1.0 - config.assist_error
    best_row, best_gain = UNMAPPED, -1.0
    for row in askable:
        mass = float(share[row].sum())
        known = share[row] / mass if mass > 0 else np.full(m, 1.0 / m)
        answer = known * (1.0 - config.assist_error) + (1.0 - known) * wrong
        gain = entropy(answer / answer.sum()) - entropy(noise / noise.sum())
        if gain > best_gain + SAME:
            best_row, best_gain = row, max(0.0, gain)
    return best_row, max(0.0, best_gain)
