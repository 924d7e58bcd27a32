"""Which further picture would tell most about the camera's pose."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.board.views import BoardCorners, BoardView, derivative, visible_corners
from mbd_robot.calibration.pairs.pair import CalibrationPair
from mbd_robot.calibration.solving.certainty import bound
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.solving.refinement import HandEyeFit
from mbd_robot.calibration.solving.spread import axis_words
from mbd_robot.calibration.transforms import Transforms, inverse, transform

ANGLES = (25.0, 45.0)  # [deg]
DIRECTIONS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
MOST_TILT = 70.0  # [deg] between the fingers and straight down, or what was shown already


@dataclass(frozen=True)
class NextPose:
    """A picture worth taking.

    Attributes:
        tool: (4, 4) tool2base.
        like: name of the picture whose hand is nearest to it.
        turn: [deg] by which the hand is turned from there.
        axis: (3,) about which, in the tool's frame.
        before: [m] the bound now.
        after: [m] the bound with that picture.
    """

    tool: Transforms
    like: str
    turn: float
    axis: Array
    before: float
    after: float

    def __str__(self) -> str:
        """In words."""
        x, y, z = self.tool[:3, 3]
        turned = (
            f"turned from there by {self.turn:.0f} deg about its {_signed(self.axis)}"
            if self.turn > 3.0
            else "as there"
        )
        return (
            f"the hand near ({x:.2f}, {y:.2f}, {z:.2f}) m, as in {self.like}, {turned}: "
            f"{self.before * 1000:.1f} mm would become {self.after * 1000:.1f} mm"
        )


def best_next_pose(problem: HandEyeProblem, fit: HandEyeFit, point: Array) -> NextPose | None:
    """The pose of a picture after which a point is known best; None where no candidate shows the board.

    Args:
        problem: pictures without wrong ones.
        fit: their solution.
        point: (3,) [m, optical frame] that matters.
    """
    information = np.linalg.inv(fit.covariance)
    before = bound(fit, point)
    best: tuple[float, Transforms] | None = None
    for tool in _candidates(problem):
        one = _foreseen(problem, fit, tool)
        if one is None:
            continue
        slope, noise = one.slopes(fit.x, fit.y)[0], one.noise(fit.y, fit.turn_noise, fit.place_noise)[0]
        known = np.linalg.inv(information + slope.T @ np.linalg.solve(noise, slope))
        after = bound(replace(fit, covariance=known), point)
        if best is None or after < best[0]:
            best = after, tool
    if best is None:
        return None
    after, tool = best
    relative = Rotation.from_matrix(np.swapaxes(problem.tools[:, :3, :3], 1, 2) @ tool[:3, :3])
    apart = relative.magnitude() + np.linalg.norm(problem.tools[:, :3, 3] - tool[:3, 3], axis=1) / 0.3
    nearest = int(np.argmin(apart))
    vector = relative[nearest].as_rotvec(degrees=True)
    turn = float(np.linalg.norm(vector))
    return NextPose(tool, problem.names[nearest], turn, vector / max(turn, 1e-9), before, after)


def _candidates(problem: HandEyeProblem) -> list[Transforms]:
    """The middle of the poses and the outermost ones, with the hand turned each way."""
    places, turns = problem.tools[:, :3, 3], Rotation.from_matrix(problem.tools[:, :3, :3])
    middle = turns.mean()
    outermost = {int(f(places[:, k])) for k in range(3) for f in (np.argmin, np.argmax)}
    spots = [np.median(places, axis=0), *(places[i] for i in sorted(outermost))]
    lowest = min(np.cos(np.radians(MOST_TILT)), float((-turns.as_matrix()[:, 2, 2]).min()))
    made = []
    for spot in spots:
        for direction in DIRECTIONS:
            for angle in ANGLES:
                turned = (middle * Rotation.from_rotvec(np.radians(angle) * np.array(direction))).as_matrix()
                if -turned[2, 2] >= lowest:
                    made.append(transform(turned, spot))
    return made


def _foreseen(problem: HandEyeProblem, fit: HandEyeFit, tool: Transforms) -> HandEyeProblem | None:
    """The problem of one picture taken at that pose; None where it would not show enough of the board."""
    given = problem.given
    empty = CalibrationPair("", tool, BoardCorners(np.empty(0, dtype=np.int64), np.empty((0, 2))))
    view = BoardView(np.eye(4), np.eye(6), 0.0, 1)
    one = replace(problem, pairs=(empty,), views=(view,))
    pose = (inverse(fit.x) @ inverse(one.arm) @ fit.y)[0]
    corners = visible_corners(pose, given.board, given.lens)
    if corners is None:
        return None
    slope = derivative(pose, given.board.corners[corners.numbers], given.lens)
    return replace(one, views=(replace(view, pose=pose, shape=np.asarray(np.linalg.inv(slope.T @ slope), np.float64)),))


def _signed(axis: Array) -> str:
    """An axis in words, and which way round about it."""
    best = int(np.argmax(np.abs(axis)))
    return axis_words(axis) + (", backwards" if axis[best] < 0 else "")
