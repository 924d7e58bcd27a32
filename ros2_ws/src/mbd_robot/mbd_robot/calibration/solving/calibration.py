"""The whole of it: from pictures to the camera's pose, what was left out, and how far off it may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.camera.pose import CameraPose
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.pairs.pair import BoardMounting, PairSet
from mbd_robot.calibration.solving.bundle import bundle
from mbd_robot.calibration.solving.certainty import bound, opened, points_that_matter
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.left_out import LeftOutErrors, left_out_errors
from mbd_robot.calibration.solving.next_pose import NextPose, best_next_pose
from mbd_robot.calibration.solving.problem import HandEyeProblem, problem_of
from mbd_robot.calibration.solving.refinement import HandEyeFit
from mbd_robot.calibration.solving.spread import one_axis, refuse_one_axis, refuse_unturned
from mbd_robot.calibration.solving.wrong_pairs import Mask, fit_agreeing
from mbd_robot.calibration.transforms import inverse, logarithm


@dataclass(frozen=True)
class HandEyeCalibration:
    """The camera's pose by hand-eye calibration.

    Attributes:
        problem: the pictures that agree.
        fit: X and Y.
        points: (n, 3) [m, optical frame] where the pose matters, the middle first.
        bounds: (n,) [m] within which each of them is put right, with 95 % probability.
        camera_bound: [m] the same of the camera itself.
        wrong: name of each picture left out, and how it disagrees, in words.
        methods: left-out errors of each method, the best first; empty where they were not asked for.
        next_pose: a picture worth taking; None where none was looked for.
    """

    problem: HandEyeProblem
    fit: HandEyeFit
    points: Array
    bounds: Array
    camera_bound: float
    wrong: dict[str, str]
    methods: tuple[LeftOutErrors, ...] = ()
    next_pose: NextPose | None = None

    @property
    def mounting(self) -> BoardMounting:
        """Which of camera and board moved."""
        return self.problem.given.mounting

    @property
    def pose(self) -> CameraPose:
        """camera2base; with the camera on the hand camera2tool."""
        return CameraPose(self.fit.x[:3, :3], self.fit.x[:3, 3])

    @property
    def quaternion(self) -> Array:
        """(4,) x, y, z, w of the optical frame."""
        return np.asarray(Rotation.from_matrix(self.fit.x[:3, :3]).as_quat())


def calibrate(
    given: PairSet,
    rng: np.random.Generator,
    table_height: float = 0.0,
    thorough: bool = True,
    allow_open: bool = False,
) -> HandEyeCalibration:
    """Find the camera's pose.

    Args:
        given: pictures of the board with their tool poses.
        rng: of the small groups that wrong pairs are found by.
        table_height: [m] of the table in the base frame, where the error is stated.
        thorough: also every method's left-out errors, and the next pose.
        allow_open: give also a solution that turns about one axis leave open, with the large error it has.

    Raises:
        AlikePosesError: the tool was turned too little, or about one axis, and that leaves the pose open.
        CalibrationError: too few pictures show the board, or agree with each other.
    """
    everything = problem_of(given)
    refuse_unturned(everything)
    if not allow_open:
        refuse_one_axis(everything)
    fit, agreeing = fit_agreeing(everything, rng)
    problem = everything.subset(agreeing).settled(fit.x, fit.y)
    if not allow_open:
        # A picture that was left out may have been the only one turned otherwise.
        refuse_one_axis(problem)
    fit = bundle(problem, fit)
    if one_axis(problem):
        fit = opened(problem, fit)
    points = points_that_matter(problem, fit.x, table_height)
    bounds = np.array([bound(fit, p) for p in points])
    return HandEyeCalibration(
        problem,
        fit,
        points,
        bounds,
        bound(fit, np.zeros(3)),
        _wrong(everything, fit, agreeing),
        tuple(left_out_errors(problem, fit)) if thorough else (),
        best_next_pose(problem, fit, points[0]) if thorough else None,
    )


def _wrong(everything: HandEyeProblem, fit: HandEyeFit, agreeing: Mask) -> dict[str, str]:
    """What is wrong with each picture that was left out: by how much its board is not where its pose says."""
    words = {}
    expected = inverse(fit.x) @ inverse(everything.arm) @ fit.y
    centre = everything.given.board.centre
    for i in np.flatnonzero(~agreeing):
        there, here = expected[i], everything.board[i]
        off = np.linalg.norm((there[:3, :3] - here[:3, :3]) @ centre + there[:3, 3] - here[:3, 3])
        turn = np.linalg.norm(logarithm(inverse(there) @ here)[:3])
        words[everything.names[i]] = f"its board is {off * 1000:.0f} mm and {np.degrees(turn):.1f} deg from its pose's"
    return words
