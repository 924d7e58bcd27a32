"""The rule on the study's own recordings."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import pytest
from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.inference import infer
from mbd_mapping.study_folder import StudySession, read_study


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
    config = MappingConfig(missing_hue=MissingHue.AS_RECORDED)
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
