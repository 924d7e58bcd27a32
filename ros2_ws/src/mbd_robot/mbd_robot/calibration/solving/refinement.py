"""The likeliest X and Y, with the noise of arm and pictures estimated from how the pictures disagree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.transforms import Transforms, exponential

ROUNDS = 8  # of noise, then X and Y, at most
SMALLEST = np.log((1e-5, 1e-6))  # of the arm's noise [log rad, log m]
# What is known beforehand of X and Y, 1 rad and 1 m: what the pictures leave open stays as it is, and counts as open.
OPEN = 1.0
NOMINAL = (0.008, 0.003)  # [rad, m] to begin with


@dataclass(frozen=True)
class HandEyeFit:
    """A solution.

    Attributes:
        x: (4, 4) camera2base, or camera2tool with the camera on the hand.
        y: (4, 4) board2tool, or board2base.
        turn_noise: [rad] of the tool's pose about an axis, standard deviation.
        place_noise: [m] of the tool's pose along an axis.
        covariance: (12, 12) of the twists of X (camera's frame) and Y (board's frame).
        freedom: degrees of freedom that the noise was estimated from.
    """

    x: Transforms
    y: Transforms
    turn_noise: float
    place_noise: float
    covariance: Array
    freedom: float


def refine(problem: HandEyeProblem, x: Transforms, y: Transforms) -> HandEyeFit:
    """From a first guess of X and Y to the likeliest, by restricted maximum likelihood and least squares.

    Args:
        problem: pictures without wrong ones.
        x: (4, 4) to begin with.
        y: (4, 4) to begin with.
    """
    logs = np.log(NOMINAL)
    covariance = np.eye(12)
    for turn in range(ROUNDS):
        seen = problem.settled(x, y)
        slopes, errors = seen.slopes(x, y), seen.disagreement(x, y)
        if turn:
            logs = _noise(seen, slopes, errors, y, logs)
        weights = np.linalg.inv(seen.noise(y, *np.exp(logs)))
        information = np.einsum("nki,nkl,nlj->ij", slopes, weights, slopes)
        covariance = np.linalg.inv(information + OPEN * np.eye(12))
        step = -covariance @ np.einsum("nki,nkl,nl->i", slopes, weights, errors)
        x, y = x @ exponential(step[:6]), y @ exponential(step[6:])
        if turn > 1 and np.abs(step).max() < 1e-7:
            break
    turn_noise, place_noise = (float(v) for v in np.exp(logs))
    return HandEyeFit(x, y, turn_noise, place_noise, covariance, max(3.0 * len(seen.pairs) - 6.0, 2.0))


def _noise(problem: HandEyeProblem, slopes: Array, errors: Array, y: Transforms, start: Array) -> Array:
    """The arm's noise [log rad, log m] that makes the disagreements likeliest, X and Y integrated out."""
    pictures = problem.noise(y, 0.0, 0.0)
    diagonal = np.arange(6)

    def unlikely(logs: Array) -> float:
        held = np.maximum(logs, SMALLEST)
        covariance = pictures.copy()
        covariance[:, diagonal, diagonal] += np.repeat(np.exp(2.0 * held), 3)
        weights = np.linalg.inv(covariance)
        weighted = np.einsum("nki,nkl->nil", slopes, weights)
        information = np.einsum("nil,nlj->ij", weighted, slopes)
        pull = np.einsum("nil,nl->i", weighted, errors)
        left = (
            np.einsum("nk,nkl,nl", errors, weights, errors) - pull @ np.linalg.lstsq(information, pull, rcond=None)[0]
        )
        beyond = float(((held - logs) ** 2).sum())
        return float(
            np.linalg.slogdet(covariance)[1].sum() + np.linalg.slogdet(information)[1] + left + beyond
        )  # fmt: skip

    found = minimize(unlikely, start, method="Nelder-Mead", options={"xatol": 0.01, "fatol": 0.003, "maxfev": 150})
    return np.maximum(found.x, SMALLEST)
