"""Hand-eye recordings of a real Jaco2 that ada_ros2 ships: MBD_ADA_CALIBRATION names their folder."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from mbd_robot.calibration.board.naming import board_of
from mbd_robot.calibration.errors import AlikePosesError
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.calibration.pairs.taken import pairs_in
from mbd_robot.calibration.solving.calibration import calibrate
from mbd_robot.calibration.solving.certainty import bound_across, open_direction
from mbd_robot.calibration.solving.left_out import REFINED

VARIABLE = "MBD_ADA_CALIBRATION"
# What ada_calibrate_camera/config/calibrate_camera.yaml says was printed, in mm.
BOARD = "14x9:18.8:13.8:5X5_100"
# And where its manual.yaml says that the camera is in the hand's frame, across the hand's z [m].
BY_HAND = (0.032, 0.127)


@pytest.fixture
def folder() -> Path:
    """ada_calibrate_camera/data/2024_10_16_17_16_32 of personalrobotics/ada_ros2."""
    given = os.environ.get(VARIABLE, "")
    if not given or not Path(given).is_dir():
        pytest.skip(f"{VARIABLE} names no folder of ada_ros2's pairs: they are kept outside the repository")
    return Path(given)


def test_a_jaco_s_pairs_foretell_each_other_and_leave_one_place_open(folder: Path) -> None:
    taken = read_pictures(folder)
    assert taken.mounting is not None
    pairs = pairs_in(taken, board_of(BOARD), taken.mounting)
    assert len(pairs.pairs) == 24 and not pairs.blind
    with pytest.raises(AlikePosesError, match="about its z axis only"):
        calibrate(pairs, np.random.default_rng(1), thorough=False)
    result = calibrate(pairs, np.random.default_rng(1), allow_open=True)
    refined = next(m for m in result.methods if m.method == REFINED)
    assert refined.millimetre_error < 8.5
    assert not result.wrong and 0.002 < result.fit.place_noise < 0.005
    across = bound_across(result.fit, result.points[0], open_direction(result.problem, result.fit))
    assert across < 0.004
    assert np.linalg.norm(result.fit.x[:2, 3] - BY_HAND) < 0.01
