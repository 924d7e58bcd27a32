"""The lens by the pictures of the board themselves, where nobody stated it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.views import BoardCorners
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens

FEWEST = 6  # pictures
DOUBTFUL = 0.03  # of the focal length: a standard deviation beyond it is refused


def estimated_lens(
    views: Sequence[BoardCorners], board: BoardPattern, size: tuple[int, int]
) -> CalibratedLens:  # fmt: skip
    """Focal lengths, principal point and two radial coefficients.

    Args:
        views: corners as the pictures have them, distortion included.
        board: that they are of.
        size: (width, height) of the pictures [px].

    Raises:
        CalibrationError: fewer than six pictures, or so alike that the focal length stays open.
    """
    if len(views) < FEWEST:
        raise CalibrationError(
            f"no lens is given, and {len(views)} pictures of the board are too few to estimate it: give --lens, or at "
            f"least {FEWEST} pictures"
        )
    points = [board.corners[v.numbers].astype(np.float32) for v in views]
    pixels = [v.pixels.astype(np.float32).reshape(-1, 1, 2) for v in views]
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_ASPECT_RATIO
    guess = np.array([[size[0], 0.0, (size[0] - 1) / 2], [0.0, size[0], (size[1] - 1) / 2], [0.0, 0.0, 1.0]])
    try:
        error, k, distortion, _, _, deviations, _, _ = cv2.calibrateCameraExtended(
            points, pixels, size, guess, None, flags=flags | cv2.CALIB_USE_INTRINSIC_GUESS
        )
    except cv2.error as problem:
        raise CalibrationError(f"the lens cannot be estimated from these pictures ({problem}); give --lens") from None
    doubt = float(np.ravel(deviations)[:2].max() / k[0, 0])  # one of the two is 0 where their ratio is held
    if not doubt < DOUBTFUL:
        raise CalibrationError(
            f"the lens stays open: its focal length is known to {doubt * 100:.0f} % only; give --lens, or pictures of "
            "the board tilted more and filling more of the picture"
        )
    origin = (
        f"estimated from {len(views)} pictures of the board: f = {k[0, 0]:.1f} px ± {doubt * 100:.2f} %, corners off "
        f"by {error:.2f} px; that of camera_info is better, where there is one"
    )
    fx, fy, cx, cy = (float(v) for v in (k[0, 0], k[1, 1], k[0, 2], k[1, 2]))
    pinhole = Intrinsics(fx, fy, cx, cy, width=size[0], height=size[1])
    return CalibratedLens(pinhole, tuple(float(v) for v in np.ravel(distortion)[:5]), origin)
