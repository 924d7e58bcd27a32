"""The suite of teachers: what a lesson is, and how it is judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mbd_experiments.csv_table import read_csv
from mbd_experiments.teacher_families import suite
from mbd_experiments.teacher_families.families import FAMILIES, Half
from mbd_experiments.teacher_families.fitting import family_error, shares_of, states_of
from mbd_experiments.teacher_families.measures import calibration_error
from mbd_experiments.teacher_families.playing import Said, finish, listen
from mbd_experiments.teacher_families.promising import Session, by_threshold, calibrate
from mbd_experiments.teacher_families.suite import lessons_of
from mbd_mapping.config import MappingConfig
from mbd_mapping.teachers.priors import FITTED

EVIDENCE = MappingConfig(strategy="evidence")
families = pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.name)


def test_at_least_half_of_the_families_are_kept_for_no_choice() -> None:
    """Twelve or more, each named once, and no fewer reported on than chosen by."""
    assert len({f.name for f in FAMILIES}) == len(FAMILIES) >= 12
    assert sum(f.half == Half.REPORT for f in FAMILIES) >= len(FAMILIES) / 2


@families
def test_a_lesson_is_a_mapping_told_object_by_object(family: object) -> None:
    """No target twice; the same seed gives the same lesson; the teacher's own mapping is right."""
    lesson = lessons_of(family, 1, 2)[1]  # type: ignore[arg-type]
    again = lessons_of(family, 1, 2)[1]  # type: ignore[arg-type]
    assert again.columns == lesson.columns
    assert again.assists == lesson.assists
    mapped = [c for c in lesson.columns if c >= 0]
    assert len(set(mapped)) == len(mapped) == min(len(lesson.source), len(lesson.target))
    assert lesson.is_right(lesson.columns)
    assert len({row for row, _ in lesson.assists}) == len(lesson.assists)


@pytest.mark.parametrize("family", [f for f in FAMILIES if f.counts is None], ids=lambda f: f.name)
def test_a_lesson_without_errors_ends_as_told(family: object) -> None:
    """When all is told and what is doubted is confirmed, every strategy does as told."""
    for strategy in suite.STRATEGY_NAMES:
        for lesson in lessons_of(family, 2, 3):  # type: ignore[arg-type]
            if all(lesson.columns[row] == column for row, column in lesson.assists):
                assert finish(lesson, MappingConfig(strategy=strategy)).as_meant


def test_calibration_error_is_the_distance_of_confidence_and_share_right() -> None:
    """Sure and right, sure and wrong, and half sure and half right."""

    def said(confidence: float, right: bool) -> Said:
        return Said(0, 1, confidence, right, right, right, False)

    assert calibration_error([said(1.0, True)] * 4) == pytest.approx(0.0)
    assert calibration_error([said(1.0, False)] * 4) == pytest.approx(1.0)
    assert calibration_error([said(0.55, True), said(0.55, False)] * 50) == pytest.approx(0.05)


def test_the_fit_weighs_as_the_product_does() -> None:
    """A state kept by group and level gives, under the fitted shares, the confidence that inference gives."""
    family = FAMILIES[0]
    lessons = lessons_of(family, 5, 2)
    confidence, right = states_of(lessons, EVIDENCE).judged(np.ones(len(shares_of(FITTED))))
    states = [s for lesson in lessons for s in listen(lesson, EVIDENCE) if s.left > 0 and not s.doubts]
    assert len(confidence) == len(states)
    for found, good, state in zip(confidence, right, states, strict=True):
        if state.best_guess_right == state.right == bool(good):
            assert found == pytest.approx(state.confidence, abs=1e-6)
    assert family_error(confidence, right) <= 1.0


def test_a_session_stops_where_it_is_sure_enough() -> None:
    """The first state that reaches the threshold counts, else the last."""
    session = Session("x", np.array([0.2, 0.6, 0.9]), np.array([2.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    assert by_threshold([session], 0.5) == (0.0, 1.0)
    assert by_threshold([session], 0.95) == (1.0, 2.0)
    calibration = calibrate([session] * 40)
    assert calibration.sessions == 20
    assert calibration.critical_score(0.5) == pytest.approx(calibration.score(0.6, 1), abs=1e-5)


def test_the_command_prints_a_family_of_both_halves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One row for each family and strategy, in the file as on the screen."""
    out = tmp_path / "suite.csv"
    names = ["--family", "one feature", "--family", "rank of size"]
    assert suite.main(["--lessons", "2", "--csv", str(out), *names]) == 0
    rows = read_csv(out)
    assert [(r["half"], r["family"], r["strategy"]) for r in rows] == [
        ("choose", "one feature", "mbd"),
        ("choose", "one feature", "evidence"),
        ("report", "rank of size", "mbd"),
        ("report", "rank of size", "evidence"),
    ]
    assert "rank of size" in capsys.readouterr().out
