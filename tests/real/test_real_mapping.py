"""The rule on the study's own recordings."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from mbd_experiments.public_study.study_data import at_assists, main, replay, stop
from mbd_experiments.public_study.study_folder import StudySession, read_study
from mbd_experiments.public_study.table5_readings import possible_of, readings
from mbd_experiments.user_study.cases import read_cases
from mbd_experiments.user_study.lab_history import ends_of, left_out, shuffled
from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.inference import infer


@pytest.fixture
def sessions(shared_data: Path) -> tuple[StudySession, ...]:
    """The 15 sessions kept beside the repository."""
    return read_study(shared_data / "hri17")


@pytest.fixture
def expected(shared_data: Path) -> dict[str, list[dict[str, str]]]:
    """Rows of expected.csv by session."""
    rows = defaultdict(list)
    with (shared_data / "hri17" / "expected.csv").open(newline="") as stream:
        for row in csv.DictReader(stream):
            rows[row["session"]].append(row)
    return rows


def test_as_recorded_equals_expected(
    sessions: tuple[StudySession, ...], expected: dict[str, list[dict[str, str]]]
) -> None:
    """Every mapping, feature, tie and correctness equals the independent reading, confidence to 1e-6."""
    config = MappingConfig("mbd", missing_hue=MissingHue.AS_RECORDED)
    assert {s.name for s in sessions} == set(expected)
    for session in sessions:
        for row in expected[session.name]:
            estimate = infer(session.task, session.target, session.assists[: int(row["assists"])], config)
            where = f"{session.name} after {row['assists']}"
            assert " ".join(sorted(f"{s}:{t}" for s, t in estimate.mapping.pairs)) == row["mapping"], where
            assert [str(f) for f in estimate.winning] == [row["feature"]], where
            assert estimate.confidence == pytest.approx(float(row["confidence"]), abs=1e-6), where
            assert estimate.ties == int(row["tied"]), where
            assert session.solved_by(estimate.mapping.as_dict) == (row["correct"] == "1"), where


def test_the_tool_writes_expected(shared_data: Path, tmp_path: Path) -> None:
    """`study_data --as-recorded` writes expected.csv, line for line."""
    out = tmp_path / "rows.csv"
    assert main([str(shared_data / "hri17"), "--as-recorded", "--csv", str(out)]) == 0
    assert out.read_text().splitlines() == (shared_data / "hri17" / "expected.csv").read_text().splitlines()


def test_mbd_as_recorded_reaches_the_papers_figures(sessions: tuple[StudySession, ...]) -> None:
    """Correct at k and, with threshold 0.015, 14 of 15 with 0.40 assists on average."""
    config = MappingConfig("mbd", missing_hue=MissingHue.AS_RECORDED)
    replays = [replay(session, config) for session in sessions]
    at = [[sum(at_assists(r, k).correct for r in replays[t : t + 5]) for k in range(5)] for t in (0, 5, 10)]
    assert at == [[4, 5, 4, 3, 3], [2, 3, 4, 3, 3], [5, 5, 5, 5, 5]]
    stops = [stop(rows, 0.015) for rows in replays]
    assert sum(row.correct for row in stops) == 14
    assert sum(row.assists for row in stops) / 15 == pytest.approx(0.40)
    assert sum(rows[-1].correct for rows in replays) == 11


@pytest.mark.xfail(strict=True, reason="13, since teachers of other kinds were taken in (issue 10)")
def test_evidence_is_right_in_14_when_all_is_told(sessions: tuple[StudySession, ...]) -> None:
    """As it was: two teachers exchanged colours throughout, which a teacher who means it now explains as well."""
    ends = [infer(s.task, s.target, s.assists, MappingConfig(strategy="evidence")) for s in sessions]
    assert sum(s.solved_by(e.best_guess.as_dict) for s, e in zip(sessions, ends, strict=True)) >= 14


def test_evidence_beats_the_rule(sessions: tuple[StudySession, ...]) -> None:
    """All assists given 13 of 15 are right, the rule's in 11; stopping at 0.25 it is right in 14 with half an assist.

    By its own threshold, 0.7, it asks more: 14 with 2.07.
    """
    config = MappingConfig(strategy="evidence")
    ends = [infer(s.task, s.target, s.assists, config) for s in sessions]
    assert sum(s.solved_by(e.best_guess.as_dict) for s, e in zip(sessions, ends, strict=True)) >= 13
    for threshold, most in ((0.25, 0.5), (config.stop_at, 2.1)):
        stops = [stop(replay(session, config), threshold) for session in sessions]
        assert sum(row.correct for row in stops) >= 14
        assert sum(row.assists for row in stops) / 15 <= most


def test_more_help_does_not_make_evidence_worse(sessions: tuple[StudySession, ...]) -> None:
    """With all assists as many sessions are right as with none; by the rule fewer than with one."""
    replays = [replay(session, MappingConfig(strategy="evidence")) for session in sessions]
    assert sum(rows[-1].correct for rows in replays) >= sum(rows[0].correct for rows in replays)


def test_a_missing_hue_does_not_count_as_a_number(sessions: tuple[StudySession, ...]) -> None:
    """Handled as grey, the missing hues change no total at any number of assists."""
    grey = [replay(session, MappingConfig("mbd")) for session in sessions]
    assert [sum(at_assists(rows, k).correct for rows in grey) for k in range(4)] == [11, 13, 13, 11]


def test_a_lab_prior_helps_the_left_out_participant(shared_data: Path) -> None:
    """Learned from the other participants, right mappings are more probable, and the best guess no less often right."""
    cases, _ = read_cases([shared_data / "hri17"])
    config = MappingConfig(strategy="evidence")
    alone, taught = left_out(cases, None, config), left_out(cases, ends_of(cases, config), config)
    assert taught.log_probability > alone.log_probability + 0.02
    assert all(after >= before for after, before in zip(taught.right, alone.right, strict=True))


def test_a_shuffled_history_of_the_lab_does_no_harm(shared_data: Path) -> None:
    """With random features in place of those that mattered, the best guess is right as often as without a history."""
    cases, _ = read_cases([shared_data / "hri17"])
    config, rng = MappingConfig(strategy="evidence"), np.random.default_rng(1)
    alone, ends = left_out(cases, None, config), ends_of(cases, config)
    scores = [left_out(cases, shuffled(ends, rng), config) for _ in range(5)]
    right = np.mean([s.right for s in scores], axis=0)
    assert (right >= np.array(alone.right) - 0.5).all()
    assert np.mean([s.log_probability for s in scores]) >= alone.log_probability - 0.02


def test_no_way_of_judging_gives_both_table_5_and_all_consistent_sessions(shared_data: Path) -> None:
    """Of the half here every way that the paper's cells leave possible maps all its sessions only by another order.

    In that order, blue before green, four of the five sortings that are not here would be right after four assists;
    the independent reading of all thirty sessions has two (docs/reproduction.md).
    """
    sessions = read_study(shared_data / "hri17")
    if len(sessions) != 15:
        pytest.skip("this is about the half of the study that is kept beside the repository")
    ways = possible_of(list(readings(sessions)))
    assert ways
    for way in ways:
        if all(r.cells[2] == r.mapped for r in way):
            assert way[1].order == ("small_orange", "small_blue", "small_green")
            assert way[1].cells[2] == 1
