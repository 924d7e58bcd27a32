"""The page that sets paper and project side by side is made of the tables, and states what its data is."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mbd_bag.ros.session_conversions import session_to_bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_experiments.csv_table import read_csv
from mbd_experiments.reproduction import reproduce
from mbd_experiments.reproduction.paper_figures import TASKS
from mbd_experiments.reproduction.remarks import REMARKS
from mbd_experiments.reproduction.reproduction_page import Page, add_experiment1
from mbd_experiments.simulated_problems import experiment1_tool
from mbd_study.synthetic import session

SCRIPT = "true_s1>true_s4 true_s2>true_s5 true_s3>true_s6"


def write_bags(folder: Path, origin: str) -> Path:
    for seed in range(2):
        made = session(f"p{seed}", np.random.default_rng(seed), num_assists=6).recorded
        facts = {**made.facts, "study.script": SCRIPT, "study.origin": origin}
        with BagWriter(folder / f"p{seed}") as bag:
            session_to_bag(replace(made, facts=facts), bag)
    return folder


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of two sessions marked as real and two simulated."""
    folder = tmp_path_factory.mktemp("study")
    real, simulated = (write_bags(folder / origin, origin) for origin in ("real", "simulated"))
    arguments = ["reproduce", "--user-study", "--case-studies", "--study", str(real), "--simulated", str(simulated)]
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr("sys.argv", [*arguments, "--out", str(folder / "out")])
        reproduce.main()
    assert ended.value.code == 0
    return folder / "out" / "reproduction.md"


def test_every_picture_it_shows_is_there_and_states_what_its_data_is(page: Path):
    shown = re.findall(r"!\[([^]]*)\]\(([^)]*)\)", page.read_text())
    assert [name for _, name in shown] == [f"img/figure{n}_{o}.png" for n in (9, 10) for o in ("real", "simulated")]
    for caption, name in shown:
        assert (page.parent / name).stat().st_size > 1000
        assert ("Real data" in caption, "Simulated data" in caption) == ("_real" in name, "_simulated" in name)


def test_no_line_of_it_is_longer_than_a_document_s_may_be(page: Path):
    assert [line for line in page.read_text().splitlines() if len(line) > 120] == []


def test_every_table_stands_beside_the_papers_numbers_with_a_remark(page: Path):
    text = page.read_text()
    sorting = TASKS["sorting"]
    assert f"| sorting | {sorting.objects} / {sorting.steps} / {sorting.solutions} | 6 / 6 / 8 | 6 / 6 / 8 |" in text
    assert "93.3 %" in text
    for key in set(REMARKS) - {"experiment1"}:
        assert REMARKS[key].strip().splitlines()[0] in text, key


def test_every_number_of_ours_is_that_of_the_tables(page: Path):
    best = [r for r in read_csv(page.parent / "simulated" / "best_thresholds.csv") if r["task"] == "all"]
    for row in best:
        line = (
            f"{row['correct']} of {row['sessions']} ({100 * float(row['share']):.1f} %) | {float(row['assists']):.2f}"
        )
        assert line in page.read_text()


def test_each_case_study_is_predicted_by_both_strategies(page: Path):
    rows = read_csv(page.parent / "case_studies.csv")
    assert {(r["case"], r["strategy"]) for r in rows} == {
        (case, strategy) for case in ("dish sorting", "assembly") for strategy in ("mbd", "evidence")
    }
    dishes = [r for r in rows if r["case"] == "dish sorting" and r["strategy"] == "mbd" and r["assists"] == "1"]
    assert [(r["predictions"], r["correct"]) for r in dishes] == [("8", "8")]


def test_experiment_1_joins_the_page_from_its_own_tables(tmp_path: Path):
    options = ["--sizes", "3", "--problems", "1", "--runs", "0", "--jobs", "1", "--out", str(tmp_path / "experiment1")]
    assert experiment1_tool.main(options) == 0
    made = Page(tmp_path / "page.md", tmp_path / "img")
    add_experiment1(made, tmp_path / "experiment1")
    text = made.write().read_text()
    first = next(r for r in read_csv(tmp_path / "experiment1" / "shares.csv") if r["method"] == "mbd")
    assert f"| 3 | mbd | {float(first['solved_within']):.2f} |" in text
    assert "img/solved_3_objects.png" in text
    assert "Simulated data" in text


def test_without_sessions_it_states_where_they_come_from(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("sys.argv", ["reproduce", "--user-study"])
    with pytest.raises(SystemExit) as ended:
        reproduce.main()
    assert ended.value.code == 2
    assert "simulate_study" in capsys.readouterr().err
