"""A linear mixed model with a random intercept for each participant, by restricted maximum likelihood (REML).

``y = X b + u[participant] + e`` with ``u ~ N(0, s_u^2)``, ``e ~ N(0, s^2)``. For a given ratio ``r = s_u^2 / s^2`` all
else has a closed form, so that one number is searched, from 0 on: no starting value, and no failure where it is 0. (The
general models of statsmodels and lme4 warn or fail there, and would be another dependency; tests compare with nlme's.)

References:
    Pinheiro, J. C., Bates, D. M. (2000): Mixed-Effects Models in S and S-PLUS. Springer. Sections 2.2 and 2.4.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

_MOST = 1e6  # of the ratio of variances


@dataclass(frozen=True)
class MixedModelFit:
    """What was fitted.

    Attributes:
        coefficients: of the columns, (p,).
        covariance: of the coefficients, (p, p).
        degrees: of freedom of each coefficient, by the inner-outer rule, (p,).
        between: standard deviation of the participants' intercepts.
        within: standard deviation of what remains.
        log_likelihood: restricted.
        residuals: of the values, the participants' intercepts taken off, (n,).
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    degrees: np.ndarray
    between: float
    within: float
    log_likelihood: float
    residuals: np.ndarray

    def contrast(self, weights: np.ndarray, degrees: float) -> tuple[float, float, float, float]:
        """A weighted sum of coefficients: its value, t, two-sided p, and half its 95 % interval.

        Args:
            weights: of the coefficients, (p,).
            degrees: of freedom.
        """
        value = float(weights @ self.coefficients)
        error = float(np.sqrt(weights @ self.covariance @ weights))
        t = value / error if error > 0 else float(np.copysign(np.inf, value)) if value else 0.0
        return value, t, float(2 * stats.t.sf(abs(t), degrees)), float(stats.t.ppf(0.975, degrees)) * error

    def wald(self, columns: Sequence[int]) -> tuple[float, int, float, float]:
        """F, its two degrees of freedom, and p, of several coefficients being all 0.

        Args:
            columns: of the coefficients.
        """
        chosen = list(columns)
        part = self.coefficients[chosen]
        f = float(part @ np.linalg.pinv(self.covariance[np.ix_(chosen, chosen)]) @ part) / len(chosen)
        degrees = float(min(self.degrees[chosen]))
        return f, len(chosen), degrees, float(stats.f.sf(f, len(chosen), degrees))


def fit_mixed_model(values: np.ndarray, design: np.ndarray, participants: np.ndarray) -> MixedModelFit:
    """Fit by REML.

    A coefficient whose column is constant within participants is tested against the participants, the others against
    what remains within them ("inner-outer", as nlme does): exact where the data is balanced.

    Args:
        values: (n,).
        design: (n, p), of full rank, the first column all 1.
        participants: number of the participant of each value, (n,).

    Raises:
        ValueError: there are not more values, or participants, than what is estimated from them.
    """
    count, width = design.shape
    groups = [np.flatnonzero(participants == g) for g in np.unique(participants)]
    outer = np.array([all(np.ptp(design[rows, k]) == 0 for rows in groups) for k in range(width)])
    free_between, free_within = len(groups) - int(outer.sum()), count - len(groups) - int((~outer).sum())
    if np.linalg.matrix_rank(design) < width:
        raise ValueError("the columns of the design depend on each other")
    if free_between < 1 or free_within < 1:
        raise ValueError(f"{count} values of {len(groups)} participants are too few for {width} coefficients")

    def solved(ratio: float) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Coefficients, their covariance by s^2, the weighted sum of squares, minus twice the log-likelihood."""
        a, b, squares, log_v = np.zeros((width, width)), np.zeros(width), 0.0, 0.0
        for rows in groups:
            x, y, n = design[rows], values[rows], len(rows)
            shrink = ratio / (1.0 + n * ratio)
            sum_x, sum_y = x.sum(axis=0), y.sum()
            a += x.T @ x - shrink * np.outer(sum_x, sum_x)
            b += x.T @ y - shrink * sum_x * sum_y
            squares += y @ y - shrink * sum_y**2
            log_v += np.log1p(n * ratio)
        inverse = np.linalg.inv(a)
        coefficients = inverse @ b
        rest = max(float(squares - b @ coefficients), 1e-12 * max(float(squares), 1e-300))
        free = count - width
        deviance = free * (1.0 + np.log(2 * np.pi * rest / free)) + log_v + np.linalg.slogdet(a)[1]
        return coefficients, inverse, rest, float(deviance)

    # From the variance share, which is bounded, so that a ratio of 0 is within the range that is searched.
    found = optimize.minimize_scalar(
        lambda share: solved(share / (1.0 - share))[3], bounds=(0.0, _MOST / (1 + _MOST)), options={"xatol": 1e-10}
    )
    share = float(found.x)
    ratio = share / (1.0 - share)
    if solved(0.0)[3] <= float(found.fun):
        ratio = 0.0
    coefficients, inverse, rest, deviance = solved(ratio)
    variance = rest / (count - width)
    residuals = values - design @ coefficients
    for rows in groups:
        residuals[rows] -= len(rows) * ratio / (1.0 + len(rows) * ratio) * residuals[rows].mean()
    return MixedModelFit(
        coefficients=coefficients,
        covariance=variance * inverse,
        degrees=np.where(outer, free_between, free_within).astype(float),
        between=float(np.sqrt(ratio * variance)),
        within=float(np.sqrt(variance)),
        log_likelihood=-deviance / 2.0,
        residuals=residuals,
    )
