"""Pictures that do not belong to their poses: found by what the others agree on, named, and left out."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.solving.hand_eye import Array, park
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.solving.refinement import NOMINAL, HandEyeFit, refine
from mbd_robot.calibration.solving.robot_world import li
from mbd_robot.calibration.solving.spread import one_axis
from mbd_robot.calibration.transforms import Transforms

TRIES = 32  # of small groups
GROUP = 4  # pictures
IMPROBABLE = 1e-3  # a picture that disagrees more than one in so many of right ones would is wrong
ROUNDS = 10
MOST_PLACE, MOST_TURN = 0.04, 0.12  # [m, rad] of an arm's error, at most
TO_CHECK = (
    "is each picture named with the pose it was taken at, are poses those of the tool in the base frame [m], did board "
    "and camera stay where they were, is --mounting right?"
)
Mask = NDArray[np.bool_]


def fit_agreeing(problem: HandEyeProblem, rng: np.random.Generator) -> tuple[HandEyeFit, Mask]:
    """Solve with those pictures that agree with each other.

    Args:
        problem: all pictures.
        rng: draws the groups tried.

    Returns:
        The solution, and which pictures it is from, (n,) bool.

    Raises:
        CalibrationError: fewer than four, or than half of the pictures, agree with each other.
    """
    x, agreeing = _first(problem, rng)
    y = problem.subset(agreeing).board_pose(x)
    seen = {agreeing.tobytes()}
    for _ in range(ROUNDS):
        problem = problem.settled(x, y)
        fit = refine(problem.subset(agreeing), x, y)
        x, y = fit.x, fit.y
        now = _judged(problem, fit, agreeing)
        if now.sum() < max(GROUP, len(now) / 2):
            break
        if (now == agreeing).all():
            return _plausible(fit), agreeing
        agreeing = now
        if agreeing.tobytes() in seen:  # a picture on the edge, in and out by turns
            return _plausible(refine(problem.subset(agreeing), x, y)), agreeing
        seen.add(agreeing.tobytes())
    if now.sum() >= max(GROUP, len(now) / 2):
        return _plausible(refine(problem.subset(now), x, y)), now
    raise CalibrationError(f"only {int(now.sum())} of {len(now)} pictures agree with each other; {TO_CHECK}")


def _plausible(fit: HandEyeFit) -> HandEyeFit:
    """The solution; raises CalibrationError where it takes an arm that errs as none does."""
    if fit.place_noise < MOST_PLACE and fit.turn_noise < MOST_TURN:
        return fit
    raise CalibrationError(
        f"the pictures do not agree with each other: their poses would be off by {fit.place_noise * 1000.0:.0f} mm and "
        f"{np.degrees(fit.turn_noise):.0f} deg; {TO_CHECK}"
    )


def _first(problem: HandEyeProblem, rng: np.random.Generator) -> tuple[Transforms, Mask]:
    """X by that group on which the middle picture disagrees least, and who agrees with it."""
    count = len(problem.pairs)
    everybody = list(combinations(range(count), GROUP)) if count <= 7 else []
    # By turns alone the camera's turn about the only axis is open; with the moves it is not.
    solve = li if one_axis(problem) else park
    groups = everybody or [tuple(rng.choice(count, GROUP, replace=False)) for _ in range(TRIES)]
    best, best_x, distances = np.inf, np.eye(4), np.zeros(count)
    for group in (tuple(range(count)), *groups):
        chosen = problem.subset(np.array(group))
        try:
            x = solve(chosen.arm, chosen.board)
            if not np.isfinite(x).all():
                continue
            y = chosen.board_pose(x)
        except (np.linalg.LinAlgError, ValueError):
            continue
        squared = _squared(problem.disagreement(x, y), problem.noise(y, *NOMINAL))
        middle = float(np.quantile(squared, 0.5, method="higher"))
        if middle < best:
            best, best_x, distances = middle, x, squared
    scale = max(best / chi2.ppf(0.5, 6), 1.0)
    return best_x, np.asarray(distances <= scale * chi2.ppf(0.999, 6))


def _judged(problem: HandEyeProblem, fit: HandEyeFit, used: Mask) -> Mask:
    """Which pictures agree with a solution, given that it was found from some of them."""
    slopes = problem.slopes(fit.x, fit.y)
    noise = problem.noise(fit.y, fit.turn_noise, fit.place_noise)
    known = slopes @ fit.covariance @ np.swapaxes(slopes, 1, 2)
    # A picture the solution was drawn to disagrees less than its noise, another one more.
    expected = np.where(used[:, None, None], noise - 0.999 * known, noise + known)
    squared = _squared(problem.disagreement(fit.x, fit.y), expected)
    return np.asarray(squared / 6.0 < f.ppf(1.0 - IMPROBABLE, 6, fit.freedom))


def _squared(errors: Array, covariance: Array) -> Array:
    """(n,) squared Mahalanobis distances."""
    return np.asarray(np.einsum("nk,nk->n", errors, np.linalg.solve(covariance, errors[..., None])[..., 0]))
