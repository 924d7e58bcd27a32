"""How far off the camera's pose may be, in millimetres where it matters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.solving.refinement import HandEyeFit
from mbd_robot.calibration.solving.spread import turn_spread
from mbd_robot.calibration.transforms import Transforms, skew

LEVEL = 0.95
OPEN = 1.0  # [m] standard deviation of what is open
DRAWS = 4000
SEED = 7  # of the draws, so that the same pictures give the same statement
GRID = 3  # points across and down the picture
FARTHEST = 3.0  # [m] of a point on the table that counts


def bound(fit: HandEyeFit, point: Array) -> float:
    """[m] within which a point seen by the camera is put right, with 95 % probability.

    Args:
        fit: the solution.
        point: (3,) [m, optical frame]; zeros: the camera itself.
    """
    rng = np.random.default_rng(SEED)
    slope = np.concatenate((-skew(point), np.eye(3)), axis=1)
    covariance = slope @ fit.covariance[:6, :6] @ slope.T
    values, axes = np.linalg.eigh(covariance)
    drawn = rng.standard_normal((DRAWS, 3)) * np.sqrt(np.maximum(values, 0.0)) @ axes.T
    drawn *= np.sqrt(fit.freedom / rng.chisquare(fit.freedom, (DRAWS, 1)))
    return float(np.quantile(np.linalg.norm(drawn, axis=1), LEVEL))


def opened(problem: HandEyeProblem, fit: HandEyeFit) -> HandEyeFit:
    """The same solution with what turns about one axis leave open counted as open, by ``OPEN`` [m].

    The arm's own noise looks like small turns about other axes: what they seem to tell is nothing.
    """
    direction = open_direction(problem, fit)
    covariance = fit.covariance.copy()
    covariance[3:6, 3:6] += OPEN**2 * np.outer(direction, direction)
    return replace(fit, covariance=covariance)


def open_direction(problem: HandEyeProblem, fit: HandEyeFit) -> Array:
    """(3,) unit vector, in the camera's frame, of the axis that the tool was turned about."""
    axis = turn_spread(problem)[1][0]
    if problem.given.mounting is BoardMounting.HAND:
        axis = problem.tools[0, :3, :3] @ axis
    return np.asarray(fit.x[:3, :3].T @ axis)


def bound_across(fit: HandEyeFit, point: Array, direction: Array) -> float:
    """[m] as ``bound``, of what is across a direction (3,) [camera's frame] alone."""
    across = np.eye(3) - np.outer(direction, direction)
    full = np.eye(12)
    full[3:6, 3:6] = across
    return bound(replace(fit, covariance=full @ fit.covariance @ full.T), point)


def off_by(fit: HandEyeFit, truth: Transforms, point: Array) -> float:
    """[m] by which a point (3,) [m, optical frame] is put wrong by a solution, where the true X is known."""
    wrong = fit.x - truth
    return float(np.linalg.norm(wrong[:3, :3] @ point + wrong[:3, 3]))


def points_that_matter(problem: HandEyeProblem, x: Transforms, table_height: float) -> Array:
    """(n, 3) [m, optical frame] points on the table that the camera sees, the middle of the picture first.

    Where the camera is on the hand, or looks past the table: the mean place of the board.
    """
    if problem.given.mounting is BoardMounting.HAND:
        on_table = table_points(problem.given.lens, x, table_height)
        if len(on_table):
            return on_table
    centre = problem.given.board.centre
    return np.asarray(np.mean(problem.board[:, :3, :3] @ centre + problem.board[:, :3, 3], axis=0)[None])


def table_points(lens: CalibratedLens, camera2base: Transforms, table_height: float) -> Array:
    """(n, 3) [m, optical frame] where rays of the picture meet the table, the middle ray's first if it does.

    Args:
        lens: of the camera.
        camera2base: (4, 4).
        table_height: [m] of the table in the base frame.
    """
    p = lens.pinhole
    shares = np.linspace(0.1, 0.9, GRID)
    u, v = np.meshgrid(shares * p.width, shares * p.height)
    rays = np.stack(((u - p.cx) / p.fx, (v - p.cy) / p.fy, np.ones_like(u)), axis=-1).reshape(-1, 3)
    order = np.argsort(np.abs(np.arange(len(rays)) - len(rays) // 2), kind="stable")
    rays = rays[order]
    fall = rays @ camera2base[2, :3]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (table_height - camera2base[2, 3]) / fall
    meets = np.isfinite(depth) & (depth > 0.05) & (depth < FARTHEST)
    return np.asarray(rays[meets] * depth[meets, None])
