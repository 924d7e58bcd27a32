"""The camera's pose from a board whose place is known by touch: where it lies, and where the camera sees it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f

from mbd_robot.calibration.board.views import BoardView
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.solving.hand_eye import Array, nearest_rotation
from mbd_robot.calibration.solving.refinement import HandEyeFit
from mbd_robot.calibration.touching.touches import Touch
from mbd_robot.calibration.transforms import Transforms, adjoint, exponential, inverse, logarithm, skew, transform

FEWEST = 4  # touches
IMPROBABLE = 1e-3  # a touch that is off more than one in so many of right ones would be is wrong
SMALLEST = 2e-4  # [m] that a touch is off, at least


@dataclass(frozen=True)
class TouchedFit:
    """The camera's pose by touch.

    Attributes:
        fit: X is camera2base, Y board2base; its place noise is that of a touch.
        off: (n,) [m] of each touch that was used.
        wrong: corner and [m] of each touch that was left out.
    """

    fit: HandEyeFit
    off: Array
    wrong: dict[str, float]


def fit_touches(touches: Sequence[Touch], views: Sequence[BoardView], pixel_noise: float) -> TouchedFit:
    """The camera's pose.

    Args:
        touches: of the board, at least four corners that are not in one line.
        views: of the board where it lies, by one picture or several of the camera that stands.
        pixel_noise: [px] of a corner.

    Raises:
        CalibrationError: too few touches, corners in one line, or touches that do not fit the board.
    """
    used = list(touches)
    wrong: dict[str, float] = {}
    while True:
        _refuse(used, wrong)
        y = _lying(used)
        away = _worst(used) if len(used) > FEWEST else None
        if away is None:
            break
        wrong[used[away[0]].corner] = away[1]
        del used[away[0]]
    residuals = np.stack([y[:3, :3] @ t.point + y[:3, 3] - t.place for t in used])
    freedom = 3.0 * len(used) - 6.0
    noise = max(float(np.sqrt((residuals**2).sum() / freedom)), SMALLEST)
    slopes = np.concatenate([np.concatenate((-y[:3, :3] @ skew(t.point), y[:3, :3]), axis=1) for t in used])
    lying = np.linalg.inv(slopes.T @ slopes) * noise**2
    seen, doubt = _seen(views, pixel_noise)
    frame = adjoint(seen)
    covariance = np.zeros((12, 12))
    covariance[:6, :6] = frame @ (lying + doubt) @ frame.T
    covariance[6:, 6:] = lying
    return TouchedFit(
        HandEyeFit(y @ inverse(seen), y, 0.0, noise, covariance, freedom), np.linalg.norm(residuals, axis=1), wrong
    )


def _refuse(used: Sequence[Touch], wrong: dict[str, float]) -> None:
    left = f", {', '.join(wrong)} left out" if wrong else ""
    if len(used) < FEWEST:
        raise CalibrationError(f"{len(used)} touches{left}; expected at least {FEWEST}, better 6, of different corners")
    points = np.stack([t.point for t in used])
    if np.linalg.svd(points - points.mean(axis=0))[1][1] < 0.01:
        raise CalibrationError("the touched corners lie in one line; expected corners on both sides of the board")


def _lying(used: Sequence[Touch]) -> Transforms:
    """(4, 4) board2base nearest to the touches."""
    points, places = np.stack([t.point for t in used]), np.stack([t.place for t in used])
    turn = nearest_rotation((places - places.mean(axis=0)).T @ (points - points.mean(axis=0)))
    return transform(turn, places.mean(axis=0) - turn @ points.mean(axis=0))


def _worst(used: Sequence[Touch]) -> tuple[int, float] | None:
    """Index and error [m] of the touch that the others contradict most; None where they contradict none."""
    found, worst = None, 1.0
    for i, touch in enumerate(used):
        others = [t for t in used if t is not touch]
        y = _lying(others)
        freedom = 3.0 * len(others) - 6.0
        squares = sum(float(((y[:3, :3] @ t.point + y[:3, 3] - t.place) ** 2).sum()) for t in others)
        noise = max(np.sqrt(squares / freedom), SMALLEST)
        off = float(np.linalg.norm(y[:3, :3] @ touch.point + y[:3, 3] - touch.place))
        # Foretold by few others, a corner is off by more than a touch is: at an edge about twice.
        ratio = (off / (2.0 * noise)) ** 2 / 3.0 / f.ppf(1.0 - IMPROBABLE, 3, freedom)
        if ratio > worst:
            found, worst = (i, off), ratio
    return found


def _seen(views: Sequence[BoardView], pixel_noise: float) -> tuple[Transforms, Array]:
    """(4, 4) board2camera of all pictures together, and the covariance of its twist in the board's frame."""
    if not views:
        raise CalibrationError("the board is in no picture; expected one that shows it where it was touched")
    first = views[0].pose
    weights = np.stack([np.linalg.inv(v.shape) for v in views])
    twists = np.stack([logarithm(inverse(first) @ v.pose) for v in views])
    doubt = np.linalg.inv(weights.sum(axis=0))
    pose = first @ exponential(doubt @ np.einsum("nij,nj->i", weights, twists))
    return pose, doubt * pixel_noise**2
