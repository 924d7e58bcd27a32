"""While pictures are taken: how far the camera's pose is known, and what to do next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbd_robot.calibration.errors import AlikePosesError, CalibrationError
from mbd_robot.calibration.pairs.pair import PairSet
from mbd_robot.calibration.solving.calibration import calibrate
from mbd_robot.calibration.solving.next_pose import best_next_pose

FEWEST = 5
SEED = 1


def progress(given: PairSet, table_height: float) -> str:
    """One line for who moves the hand; never raises for poor pictures."""
    if len(given.pairs) < FEWEST:
        return "next: elsewhere in the picture, with the hand turned by 20 to 45 deg about another of its axes"
    try:
        result = calibrate(given, np.random.default_rng(SEED), table_height, thorough=False)
    except AlikePosesError as error:
        return str(error)
    except CalibrationError as error:
        return f"not solved yet: {error}"
    result = replace(result, next_pose=best_next_pose(result.problem, result.fit, result.points[0]))
    wrong = f"; left out {', '.join(result.wrong)}" if result.wrong else ""
    nearer = f"; next: {result.next_pose}" if result.next_pose else ""
    return f"known to {result.bounds[0] * 1000.0:.1f} mm (95 %){wrong}{nearer}"
