"""The analysis of the paper's own user study: its headline figures, and what half of its participants can show."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from mbd_study.analysis.comparing import overall_rows, sensitivity_rows
from mbd_study.analysis.describing import condition_rows, wilson_interval
from mbd_study.analysis.study_table import StudyTable, measured_values

THRESHOLD = 0.015  # of the study's README: 14 of 15 correct, 0.40 assists on average


@pytest.fixture(scope="module")
def table() -> StudyTable:
    """Each session without help, and with as many assists as its confidence asked for."""
    path = Path(__file__).resolve().parents[3] / "shared" / "hri17" / "expected.csv"
    if not path.is_file():
        pytest.skip(f"{path} is absent: the study's data is kept outside the repository")
    sessions: dict[str, list[dict[str, str]]] = {}
    with path.open(newline="") as stream:
        for row in csv.DictReader(stream):
            sessions.setdefault(row["session"], []).append(row)
    rows = []
    for name, course in sessions.items():
        confident = next((r for r in course if float(r["confidence"]) >= THRESHOLD), course[-1])
        participant, task = name.split("_")
        for condition, row in (("unguided", course[0]), ("guided", confident)):
            cells = {"participant": participant, "task": task, "condition": condition}
            rows.append({**cells, "correct": row["correct"], "assists": row["assists"]})
    return StudyTable(tuple(rows))


def test_the_papers_headline_comes_out_with_its_interval(table: StudyTable):
    guided = StudyTable(tuple(r for r in table.rows if r["condition"] == "guided"))
    correct = measured_values(guided, "correct", by="task", participant="participant")
    assists = measured_values(guided, "assists", by="task", participant="participant")
    assert sum(v.value for v in correct.values) == 14
    assert sum(v.value for v in assists.values) / 15 == pytest.approx(0.40)
    # 93.3 % of the paper's 30 sessions were right; 15 of them leave this much open.
    assert wilson_interval(14, 15) == pytest.approx((0.702, 0.988), abs=1e-3)
    rows = {r.condition: r for r in condition_rows(correct)}
    assert [rows[t].mean for t in ("t0", "t1", "t2")] == pytest.approx([1.0, 0.8, 1.0])
    assert all(r.ci_by == "Wilson" for r in rows.values())
    (test,) = overall_rows([correct])
    assert (test.test, test.p) == ("Cochran's Q (exact)", 1.0)


def test_half_of_the_participants_cannot_show_that_guidance_helps_and_the_analysis_says_so(table: StudyTable):
    correct = measured_values(table, "correct", by="condition", participant="participant", block="task")
    means = {r.condition: r.mean for r in condition_rows(correct)}
    assert means == pytest.approx({"unguided": 11 / 15, "guided": 14 / 15})
    (row,) = sensitivity_rows(correct)
    assert row.participants == "5 pairs"
    assert row.least_p == pytest.approx(2 / 32)
    assert "no result could be significant" in row.words
