"""Complete sessions on robots and cameras that the cell plays, with no code but a profile's name."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from mbd_bringup.ros.robot_sessions import main, pair_session, rows
from mbd_model.errors import MbdError

pytestmark = pytest.mark.timeout(900)


# What differs most; the command `robots` leads every pair (docs/testing.md).
@pytest.mark.parametrize(
    ("robot", "camera"),
    [
        ("jaco2", "realsense_compressed"),
        ("ada", "orbbec"),
        ("fr3", "azure_kinect"),
        ("ur5e", "zed"),
    ],
)
def test_a_session_is_led_to_its_end_with_every_object_in_its_place(robot: str, camera: str, tmp_path: Path):
    """Kinova's poses, compressed; hand guiding by a person; a hand with joint states of its own; freedrive."""
    led = pair_session(robot, camera, task="sorting", seed=1, folder=tmp_path, timeout=600.0)
    assert led.complete, f"{rows([led])[1]}; see {tmp_path}"


def test_a_robot_that_is_none_is_refused_before_anything_is_started(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(MbdError, match="did you mean 'gen3'"):
        pair_session("gen33", "zed", task="sorting", seed=1, folder=tmp_path, timeout=600.0)
    with pytest.raises(SystemExit) as ended:
        main(["--robots", "gen33", "--cameras", "zed", "--out", str(tmp_path / "out")])
    assert ended.value.code == 1
    assert "no robot 'gen33'" in capsys.readouterr().err
    with (tmp_path / "out" / "robots.csv").open() as table:
        assert list(csv.DictReader(table)) == []
