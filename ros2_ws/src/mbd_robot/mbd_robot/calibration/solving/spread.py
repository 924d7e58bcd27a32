"""How differently the tool was turned: from too little of that no camera's pose can be known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mbd_robot.calibration.errors import AlikePosesError, CalibrationError
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.solving.problem import HandEyeProblem

LEAST, GOOD = 3.0, 12.0  # [deg] of turn about the second axis


def turn_spread(problem: HandEyeProblem) -> tuple[Array, Array]:
    """By how much the tool was turned, about which axes.

    Returns:
        (3,) root mean square turn [deg] about each of three axes, largest first, and (3, 3) those axes in the tool's
        frame, a row each.
    """
    turns = Rotation.from_matrix(problem.tools[:, :3, :3])
    vectors = (turns.mean().inv() * turns).as_rotvec()
    squared, axes = np.linalg.eigh(vectors.T @ vectors / len(vectors))
    return np.degrees(np.sqrt(np.maximum(squared[::-1], 0.0))), axes.T[::-1]


def refuse_unturned(problem: HandEyeProblem) -> None:
    """Refuse pictures from which nothing can be computed.

    Raises:
        AlikePosesError: the tool was hardly turned at all.
        CalibrationError: every picture has the same tool pose.
    """
    spread, _ = turn_spread(problem)
    if spread[0] >= LEAST:
        return
    if np.ptp(problem.tools[:, :3, 3], axis=0).max() < 1e-3 and spread[0] < 0.1:
        raise CalibrationError(
            "all pictures have the same tool pose; expected the pose at which each was taken: does the file of poses "
            "hold one a picture, and does the tool's pose arrive?"
        )
    raise AlikePosesError(
        f"the poses are too alike: the tool was turned by {spread[0]:.1f} deg only, and where the camera is cannot be "
        "told from moves without turns; turn the hand by 20 to 45 deg about each of its x, y and z"
    )


def one_axis(problem: HandEyeProblem) -> bool:
    """Whether the tool was turned about one axis only."""
    return bool(turn_spread(problem)[0][1] < LEAST)


def refuse_one_axis(problem: HandEyeProblem) -> None:
    """Refuse pictures that turned the tool about one axis.

    Raises:
        AlikePosesError: states about which axis the tool was turned, and about which to turn it.
    """
    if not one_axis(problem):
        return
    spread, axes = turn_spread(problem)
    raise AlikePosesError(
        f"the poses are too alike: the tool was turned about its {axis_words(axes[0])} only ({spread[0]:.0f} deg, and "
        f"{spread[1]:.1f} deg about any other), which leaves the camera's place along that axis open; "
        f"take pictures with the hand turned by 20 to 45 deg about its {axis_words(axes[1])} "
        "as well, to both sides (--anyway gives it as it is)"
    )


def spread_words(problem: HandEyeProblem) -> str:
    """A sentence when there is enough spread, but little; "" when there is plenty."""
    spread, axes = turn_spread(problem)
    if spread[1] >= GOOD:
        return ""
    return (
        f"The tool was turned little: {spread[0]:.0f}, {spread[1]:.0f} and {spread[2]:.0f} deg about three axes; "
        f"more turn about its {axis_words(axes[1])} and {axis_words(axes[2])} tells most."
    )


def axis_words(axis: Array) -> str:
    """An axis of the tool in words: x, y or z where it nearly is one, else numbers."""
    best = int(np.argmax(np.abs(axis)))
    if abs(axis[best]) > 0.94:
        return f"{'xyz'[best]} axis"
    return f"axis ({', '.join(f'{v:.2f}' for v in axis * np.sign(axis[best]))})"
