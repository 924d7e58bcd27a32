"""X and Y refined over the reprojection error of every corner, the arm's noise taken into account.

Corners of one picture err together when the tool was not where its pose says: weighed as if they erred alone, a
picture with many corners would count for many pictures. Their covariance is the picture's own noise and that of the
tool's pose, seen through the lens.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import least_squares

from mbd_robot.calibration.board.views import derivative
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.solving.refinement import HandEyeFit
from mbd_robot.calibration.transforms import Transforms, adjoint, exponential, inverse


def bundle(problem: HandEyeProblem, fit: HandEyeFit) -> HandEyeFit:
    """The same solution with X and Y where the weighed reprojection error is least.

    Args:
        problem: pictures without wrong ones.
        fit: to begin with; its noise is kept.
    """
    boards = inverse(problem.boards_in_tool(fit.y))
    arm = np.diag([fit.turn_noise**2] * 3 + [fit.place_noise**2] * 3)
    corners = problem.given.board.corners
    roots = []
    for pair, view, board in zip(problem.pairs, problem.views, boards, strict=True):
        slope = derivative(view.pose, corners[pair.corners.numbers], problem.given.lens) @ adjoint(board)
        covariance = slope @ arm @ slope.T + problem.pixel_noise**2 * np.eye(len(slope))
        roots.append(cholesky(covariance, lower=True))

    def weighed(twists: Array) -> Array:
        x, y = fit.x @ exponential(twists[:6]), fit.y @ exponential(twists[6:])
        errors = reprojection_errors(problem, x, y)
        # A corner behind the camera is far off, not nowhere.
        finite = [np.nan_to_num(e.reshape(-1), nan=1e4) for e in errors]
        return np.concatenate([solve_triangular(r, e, lower=True) for r, e in zip(roots, finite, strict=True)])

    found = least_squares(weighed, np.zeros(12), x_scale=np.array([0.01] * 3 + [0.005] * 3 + [0.01] * 3 + [0.005] * 3))
    return replace(fit, x=fit.x @ exponential(found.x[:6]), y=fit.y @ exponential(found.x[6:]))


def reprojection_errors(problem: HandEyeProblem, x: Transforms, y: Transforms) -> list[Array]:
    """(k, 2) [px] for each picture: where its corners should be by its tool pose, less where they are."""
    expected = inverse(x) @ inverse(problem.arm) @ y
    errors = []
    for pair, pose in zip(problem.pairs, expected, strict=True):
        points = problem.given.board.corners[pair.corners.numbers] @ pose[:3, :3].T + pose[:3, 3]
        errors.append(problem.given.lens.project(points) - pair.corners.pixels)
    return errors
