"""Trajectories that users' recordings once were answered badly on: each has its right steps."""

from __future__ import annotations

from pathlib import Path

import pytest
from mbd_demonstration.steps_command import run

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "cases" / "demonstration"
pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(), reason=f"{FOLDER} is absent: the cases are kept outside the repository"
)


def output(case: str, *options: str) -> list[str]:
    folder = FOLDER / case
    words = [str(folder / "traj.csv"), "--scene", str(folder / "scene.yaml"), "--polarity", "larger_closed"]
    return run([*words, *options]).splitlines()


def steps(lines: list[str]) -> list[str]:
    return [" ".join(line.split()[2:4]) for line in lines if line.split()[0].isdigit() and "steps" not in line]


@pytest.mark.parametrize(
    ("case", "options", "expected"),
    [
        ("doc_levels_real_jaco", ("--open-level", "0.4", "--closed-level", "1.0"), "PICK w; PLACE w; PICK n; PLACE n"),
        ("wide_with_levels", ("--open-level", "0", "--closed-level", "1"), "PICK w; PLACE w; PICK n; PLACE n"),
        ("initial_stack_moved", (), "PICK b; PLACE b; PICK a; PLACE a"),
        ("thin_beside", (), "PICK pen; PLACE pen"),
        ("withdraw_during_opening", (), "PICK a; PLACE b"),
    ],
)
def test_steps_are_those_that_were_shown(case: str, options: tuple[str, ...], expected: str):
    assert "; ".join(steps(output(case, *options))) == expected


def test_an_object_put_down_by_a_hand_that_withdraws_is_placed_where_it_was_let_go():
    [place] = [line.split() for line in output("withdraw_during_opening") if " PLACE " in line]
    assert 7.0 <= float(place[1]) <= 8.0


def test_one_sample_a_second_gives_the_steps_or_says_that_it_cannot():
    lines = output("one_hz")
    assert steps(lines) == ["PICK a", "PLACE b", "PICK c", "PLACE c"] or any("sampled" in line for line in lines)
    assert not any("never closed" in line for line in lines)


def test_stamps_that_went_back_to_those_since_boot_are_named_with_the_number():
    lines = output("driver_restart_boot_stamps")
    assert any("went back by 1.7e+09 s" in line or "went back 1.7e+09 s" in line for line in lines)
    assert steps(lines) in ([], ["PICK a", "PLACE b", "PICK c", "PLACE c"])
