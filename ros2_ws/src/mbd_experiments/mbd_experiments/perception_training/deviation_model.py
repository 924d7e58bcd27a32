"""Fitting standard deviations to errors, and whether they hold on others: how many errors lie within one and two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.errors import MbdError
from mbd_perception.features.deviations import DEVIATIONS, predicted
from mbd_perception.features.evidence_of_error import EVIDENCE
from scipy.optimize import minimize

from mbd_experiments.perception_training.feature_errors import FeatureError
from mbd_experiments.perception_training.feature_truth import Floats

# Of normal errors: the share within one and within two standard deviations.
WITHIN_ONE, WITHIN_TWO = 0.683, 0.954
# Less is claimed of nothing: millimetres, milliradians, a degree of hue (whose angle is itself off by up to 1.1).
RESOLUTION = dict.fromkeys(DEVIATIONS, 2e-4) | {"hue": 1.0, "yaw": 1e-3, "volume": 2e-3, "saturation": 5e-3}
FEWEST = 60


def fitted_weights(errors: Sequence[FeatureError], ridge: float) -> Floats:
    """The table of weights that ``predicted`` takes.

    Of each deviation the logarithm s is fitted so that ``WITHIN_ONE`` of the errors are below it and ``WITHIN_TWO``
    below twice it: the sum of both quantile losses of log|error| - s, as in quantile regression.

    Args:
        errors: to learn from.
        ridge: how much large weights cost.

    Raises:
        MbdError: fewer than 60 objects have a truth for one of the features.
    """
    errors = [e for e in errors if e.owned]
    evidence = np.array([e.evidence for e in errors]).reshape(-1, len(EVIDENCE))
    off = np.array([e.errors for e in errors]).reshape(-1, len(DEVIATIONS))
    known = np.isfinite(off).sum(axis=0)
    if known.min() < FEWEST:
        name = DEVIATIONS[int(known.argmin())]
        raise MbdError(
            f"only {known.min()} objects have a true {name}, at least {FEWEST} are needed: give more --rooms"
        )
    low, high = np.quantile(evidence, (0.005, 0.995), axis=0)
    within = np.clip(evidence, low, high)
    mean, spread = within.mean(axis=0), np.maximum(within.std(axis=0), 1e-6)
    scaled = (within - mean) / spread
    rows = [np.concatenate([[0.0], low]), np.concatenate([[0.0], high])]
    for number, name in enumerate(DEVIATIONS):
        has = np.isfinite(off[:, number])
        size = np.log(np.maximum(np.abs(off[has, number]), RESOLUTION[name]))
        b = _fit(scaled[has], size, ridge)
        weights = b[1:] / spread
        rows.append(np.concatenate([[b[0] - weights @ mean], weights]))
    return np.array(rows)


def _fit(rows: Floats, size: Floats, ridge: float) -> Floats:
    """(k + 1,) bias and weights of the logarithm of a standard deviation; ``size`` (n,) = log|error|."""

    def loss(b: Floats) -> tuple[float, Floats]:
        total, slope = 0.0, np.zeros(len(size))
        for share, factor in ((WITHIN_ONE, 1.0), (WITHIN_TWO, 2.0)):
            rest = size - np.log(factor) - (b[0] + rows @ b[1:])
            # The quantile loss, its corner rounded over a tenth, for the search needs a slope.
            total += float((share * rest + 0.1 * np.logaddexp(0.0, -rest / 0.1)).mean())
            slope -= share - 1.0 / (1.0 + np.exp(np.clip(rest / 0.1, -50, 50)))
        total += ridge * float(b[1:] @ b[1:])
        gradient = np.concatenate([[slope.mean()], rows.T @ slope / len(size) + 2 * ridge * b[1:]])
        return total, gradient

    start = np.zeros(rows.shape[1] + 1)
    start[0] = np.quantile(size, WITHIN_ONE)
    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B").x)


@dataclass(frozen=True)
class Coverage:
    """How one feature's stated standard deviations hold on a set of errors.

    Attributes:
        name: of ``DEVIATIONS``.
        count: errors with a truth.
        within_one, within_two: share within one and two stated standard deviations.
        typical: median of those stated, in their unit.
        rank: Spearman's correlation of what is stated with the size of the error: above 0 where it tells objects apart.
    """

    name: str
    count: int
    within_one: float
    within_two: float
    typical: float
    rank: float


def coverage(errors: Sequence[FeatureError], weights: Floats) -> list[Coverage]:
    """Of each deviation, in order; NaN where no error has a truth."""
    errors = [e for e in errors if e.owned]
    std = predicted(np.array([e.evidence for e in errors]), weights)
    off = np.abs(np.array([e.errors for e in errors]))
    found = []
    for number, name in enumerate(DEVIATIONS):
        has = np.isfinite(off[:, number])
        error, stated = off[has, number], std[has, number]
        one, two = (float(np.mean(error <= k * stated)) if has.any() else np.nan for k in (1, 2))
        typical = float(np.median(stated)) if has.any() else np.nan
        found.append(Coverage(name, int(has.sum()), one, two, typical, _rank_correlation(error, stated)))
    return found


def _rank_correlation(a: Floats, b: Floats) -> float:
    if len(a) < 3:
        return float("nan")
    first, second = (v.argsort().argsort().astype(np.float64) for v in (a, b))
    return float(np.corrcoef(first, second)[0, 1])
