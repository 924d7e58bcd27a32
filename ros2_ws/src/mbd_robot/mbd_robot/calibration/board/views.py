"""What a picture shows of the board: which corners, where, and where the board is before the camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.transforms import Transforms, exponential, skew, transform

FEWEST = 6  # corners from which a pose is taken
ENOUGH = 0.7  # share of the corners from which nothing more is tried
FINEST = 0.05  # [px] of a corner, at best: lens and print are never better known
TURNS = 20  # of Gauss-Newton, at most


@dataclass(frozen=True)
class BoardCorners:
    """Corners found in a picture.

    Attributes:
        numbers: (n,) of each corner on the board.
        pixels: (n, 2) where it is [px], as if the lens had no distortion.
    """

    numbers: NDArray[np.int64]
    pixels: NDArray[np.float64]


@dataclass(frozen=True)
class BoardView:
    """The board before the camera, by one picture.

    Attributes:
        pose: board2camera.
        shape: (6, 6) covariance of the twist of ``pose``, in the board's frame, for corners off by 1 px.
        squares: sum of the squared residuals [px^2].
        freedom: residuals less the six numbers found by them.
        other: the second pose that a flat board nearly allows; None where it fits clearly worse.
    """

    pose: Transforms
    shape: NDArray[np.float64]
    squares: float
    freedom: int
    other: Transforms | None = None


def find_corners(picture: NDArray[np.uint8], board: BoardPattern, lens: CalibratedLens | None) -> BoardCorners | None:
    """The board's corners in a picture; None where fewer than six are seen.

    Args:
        picture: (H, W) or (H, W, 3) uint8.
        board: what to look for.
        lens: takes its distortion away; None leaves the pixels as they are.
    """
    grey = picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
    found, numbers = board.detected(grey, thorough=False)
    if len(numbers) < ENOUGH * len(board.corners):
        found, numbers = max((found, numbers), board.detected(grey, thorough=True), key=lambda f: len(f[1]))
    if len(numbers) < FEWEST:
        return None
    points = board.corners[numbers]
    # Corners of one row or column alone leave the board free to turn about them.
    if np.linalg.matrix_rank(points[:, :2] - points[:, :2].mean(axis=0), tol=1e-4) < 2:
        return None
    return BoardCorners(numbers, found if lens is None else lens.undistorted(found))


def view_of(corners: BoardCorners, board: BoardPattern, lens: CalibratedLens) -> BoardView | None:
    """Where the board is before the camera; None where no pose explains the corners."""
    points = board.corners[corners.numbers]
    count, turns, places, _ = cv2.solvePnPGeneric(
        points, corners.pixels, lens.matrix, None, flags=cv2.SOLVEPNP_IPPE
    )  # fmt: skip
    views = []
    for turn, place in zip(turns[:count], places[:count], strict=True):
        start = transform(cv2.Rodrigues(turn)[0], np.asarray(place).reshape(3))
        view = _refined(start, points, corners.pixels, lens)
        if view is not None:
            views.append(view)
    if not views:
        return None
    views.sort(key=lambda v: v.squares)
    best = views[0]
    rivals = [v.pose for v in views[1:] if v.squares < 4.0 * best.squares + 1.0]
    return BoardView(best.pose, best.shape, best.squares, best.freedom, rivals[0] if rivals else None)


def visible_corners(pose: Transforms, board: BoardPattern, lens: CalibratedLens) -> BoardCorners | None:
    """The corners within the picture for a board2camera (4, 4); None for fewer than twelve, or from behind or aside."""
    towards = pose[:3, :3] @ board.centre + pose[:3, 3]
    if towards[2] < 0.1 or pose[:3, 2] @ towards / np.linalg.norm(towards) < 0.4:
        return None
    pixels = lens.project(board.corners @ pose[:3, :3].T + pose[:3, 3])
    inside = (pixels > 4).all(axis=1) & (pixels < np.array([lens.pinhole.width, lens.pinhole.height]) - 5).all(axis=1)
    if inside.sum() < 12:
        return None
    return BoardCorners(np.flatnonzero(inside).astype(np.int64), pixels[inside])


def derivative(pose: Transforms, points: NDArray[np.float64], lens: CalibratedLens) -> NDArray[np.float64]:
    """(2n, 6) of the pixels of points (n, 3) by the twist of ``pose`` in the board's frame."""
    seen = _moved(pose, points)
    slope = np.zeros((len(points), 2, 3))
    slope[:, 0, 0], slope[:, 1, 1] = lens.pinhole.fx / seen[:, 2], lens.pinhole.fy / seen[:, 2]
    slope[:, 0, 2] = -lens.pinhole.fx * seen[:, 0] / seen[:, 2] ** 2
    slope[:, 1, 2] = -lens.pinhole.fy * seen[:, 1] / seen[:, 2] ** 2
    turned = slope @ pose[:3, :3]
    return np.concatenate((-turned @ skew(points), turned), axis=2).reshape(-1, 6)


def _moved(poses: Transforms, points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.einsum("...ij,nj->...ni", poses[..., :3, :3], points) + poses[..., None, :3, 3])


def _refined(
    pose: Transforms, points: NDArray[np.float64], pixels: NDArray[np.float64], lens: CalibratedLens
) -> BoardView | None:
    """Gauss-Newton over the reprojection error, with its covariance."""
    for _ in range(TURNS):
        error = (lens.project(_moved(pose, points)) - pixels).reshape(-1)
        if not np.isfinite(error).all():
            return None
        slope = derivative(pose, points, lens)
        step = np.asarray(np.linalg.lstsq(slope, -error, rcond=None)[0], dtype=np.float64)
        pose = np.asarray(pose @ exponential(step))
        if np.abs(step).max() < 1e-9:
            break
    error = (lens.project(_moved(pose, points)) - pixels).reshape(-1)
    if not np.isfinite(error).all() or pose[2, 3] <= 0.0:
        return None
    slope = derivative(pose, points, lens)
    information = slope.T @ slope
    if np.linalg.cond(information) > 1e14:
        return None
    return BoardView(pose, np.asarray(np.linalg.inv(information), np.float64), float(error @ error), len(error) - 6)
