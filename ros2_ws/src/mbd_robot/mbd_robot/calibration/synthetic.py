"""Pictures of a board with known truth: noise in pixels and of the arm, wrong pairs, motions that tell too little."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.board.views import BoardCorners, visible_corners
from mbd_robot.calibration.lens import CalibratedLens
from mbd_robot.calibration.pairs.pair import BoardMounting, CalibrationPair, PairSet
from mbd_robot.calibration.transforms import Transforms, exponential, inverse, transform

LENS = CalibratedLens(Intrinsics(610.0, 611.0, 319.0, 241.0, width=640, height=480), (), "synthetic")
TRIES = 2000


@dataclass(frozen=True)
class KnownPairs:
    """Pairs, and the truth behind them.

    Attributes:
        given: what a calibration gets.
        x: (4, 4) camera2base or camera2tool.
        y: (4, 4) board2tool or board2base.
    """

    given: PairSet
    x: Transforms
    y: Transforms


@dataclass(frozen=True)
class PairNoise:
    """By how much what is measured is off, standard deviations.

    Attributes:
        pixels: [px] of u and of v of a corner.
        place: [m] of the tool along each axis.
        turn: [rad] of the tool about each axis.
        tilt: [rad] by which the tool is turned from picture to picture.
        axes: (3,) which axes of the tool it is turned about, 0 or 1 each.
    """

    pixels: float = 0.2
    place: float = 0.002
    turn: float = 0.004
    tilt: float = 0.45
    axes: tuple[float, float, float] = (1.0, 1.0, 1.0)


def known_pairs(
    rng: np.random.Generator,
    count: int = 12,
    mounting: BoardMounting = BoardMounting.HAND,
    noise: PairNoise | None = None,
    board: BoardPattern | None = None,
) -> KnownPairs:
    """Pairs of a camera that looks down at a table from in front.

    Args:
        rng: of all that is random.
        count: of pictures.
        mounting: which of camera and board moves.
        noise: of what is measured, and how the tool is moved.
        board: that is seen.
    """
    noise, board = noise or PairNoise(), board or PrintedBoard()
    centre = transform(np.eye(3), board.centre)
    if mounting is BoardMounting.HAND:
        # The board faces the camera, which stands 1 m away, when the hand points down.
        x = _looking(np.array([1.15, 0.1, 0.85]), np.array([0.5, 0.0, 0.25]), rng)
        facing = x.copy()
        facing[:3, 3] = (0.5, 0.0, 0.25)
        home = transform(Rotation.from_euler("x", np.pi).as_matrix(), (0.5, 0.0, 0.3))
        y = inverse(home) @ facing @ exponential(rng.normal(0.0, (0.1,) * 3 + (0.01,) * 3)) @ inverse(centre)
    else:
        home = transform(Rotation.from_euler("x", np.pi).as_matrix(), (0.5, 0.0, 0.55))
        x = transform(np.eye(3), (-0.04, 0.07, -0.1)) @ exponential(rng.normal(0.0, (0.05,) * 3 + (0.01,) * 3))
        y = transform(Rotation.from_euler("x", np.pi).as_matrix(), (0.5, 0.0, 0.0)) @ inverse(centre)
    pairs: list[CalibrationPair] = []
    for _ in range(TRIES):
        if len(pairs) == count:
            break
        place = rng.normal(0.0, (0.08, 0.08, 0.05))
        turn = rng.normal(0.0, noise.tilt, 3) * noise.axes
        tool = transform(Rotation.from_rotvec(turn).as_matrix() @ home[:3, :3], home[:3, 3] + place)
        pose = inverse(x) @ tool @ y if mounting is BoardMounting.HAND else inverse(x) @ inverse(tool) @ y
        corners = visible_corners(pose, board, LENS)
        if corners is None:
            continue
        pixels = corners.pixels + rng.normal(0.0, noise.pixels, corners.pixels.shape)
        told = tool @ exponential(rng.normal(0.0, (noise.turn,) * 3 + (noise.place,) * 3))
        pairs.append(CalibrationPair(f"{len(pairs):02d}", told, BoardCorners(corners.numbers, pixels)))
    return KnownPairs(PairSet(mounting, board, LENS, pairs, "base", "camera"), x, y)


def _looking(place: np.ndarray[tuple[int], np.dtype[np.float64]], at: object, rng: np.random.Generator) -> Transforms:
    """(4, 4) of a camera at a place that looks at a point, upright, a little off."""
    forward = np.asarray(at, dtype=np.float64) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    turned = np.stack((right, np.cross(forward, right), forward), axis=1)
    return transform(turned, place) @ exponential(rng.normal(0.0, (0.05,) * 3 + (0.03,) * 3))
