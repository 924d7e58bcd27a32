"""Tables hold every session, step, assist and estimate once; a report is one page that needs nothing else."""

from __future__ import annotations

import csv
import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag, session_to_bag
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_paths import bags_below
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.superseded import supersede
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_study.figures import report
from mbd_study.recompute.reevaluate_command import check_bags
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.synthetic import SyntheticSession, session
from mbd_study.tables import export
from mbd_study.tables.events import event_rows


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five sessions in folders, and a first try of one."""
    folder = tmp_path_factory.mktemp("study")
    for number in range(5):
        path = folder / f"p{number}" / "bag"
        path.parent.mkdir()
        for _ in range(2 if number == 3 else 1):
            if path.exists():
                supersede(path)
            made = session(f"p{number}", np.random.default_rng(number), num_assists=number)
            with BagWriter(path) as bag:
                session_to_bag(made.recorded, bag)
    return folder


def run(tool: object, monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["tool", *words])
    with pytest.raises(SystemExit) as ended:
        tool.main()
    return int(ended.value.code)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_tables_hold_everything_once_and_are_not_overwritten(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    out = tmp_path / "tables"
    assert run(export, monkeypatch, str(study), "--out", str(out)) == 0
    sessions = rows(out / "sessions.csv")
    assert [r["session"] for r in sessions] == [f"p{k}" for k in range(5)]
    assert [int(r["assists"]) for r in sessions] == list(range(5))
    assert {r["correct"] for r in sessions} <= {"true", "false"}
    assert len(rows(out / "steps.csv")) == 5 * 6
    assert len(rows(out / "estimates.csv")) == sum(k + 1 for k in range(5))
    # Each list of assists is one revision: 1 + 2 + ... + k rows for k assists.
    assert len(rows(out / "assists.csv")) == sum(k * (k + 1) // 2 for k in range(5))
    assert {r["right"] for r in rows(out / "assists.csv")} == {"true"}
    assert run(export, monkeypatch, str(study), "--out", str(out)) == 2
    assert "not overwritten" in " ".join(capsys.readouterr().err.split())
    assert run(export, monkeypatch, str(study), "--out", str(out / "sessions.csv")) == 2
    assert "choose another place" in " ".join(capsys.readouterr().err.split())
    again = tmp_path / "all"
    assert run(export, monkeypatch, str(study), "--out", str(again), "--superseded") == 0
    assert [r["superseded"] for r in rows(again / "sessions.csv")].count("true") == 1


def test_parquet_holds_the_same_as_csv_or_states_what_it_needs(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    code = run(export, monkeypatch, str(study), "--out", str(tmp_path / "t"), "--parquet")
    try:
        from pyarrow import parquet
    except ImportError:
        assert code == 2
        assert "pip install pyarrow" in " ".join(capsys.readouterr().err.split())
        return
    assert code == 0
    table = parquet.read_table(tmp_path / "t" / "estimates.parquet").to_pylist()
    text = rows(tmp_path / "t" / "estimates.csv")
    assert [r["confidence"] for r in table] == [float(r["confidence"]) for r in text]
    assert [r["confident"] for r in table] == [r["confident"] == "true" for r in text]


class Links(HTMLParser):
    """Collects what a page would load or link to, and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag not in ("script", "link", "iframe")
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_a_report_is_one_page_with_pictures_and_timeline_that_loads_nothing(
    made_bag: Path, made: SyntheticSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    out = tmp_path / "report.html"
    assert run(report, monkeypatch, str(made_bag), "--out", str(out)) == 0
    page = out.read_text()
    found = Links()
    found.feed(page)
    assert len(found.links) == 1
    assert found.links[0].startswith("data:image/png;base64,")
    assert "default-src 'none'" in page
    assert "url(" not in page
    words = " ".join(found.words)
    assert "4 of 4 estimates come out again" in words
    events = event_rows(Bag(made_bag), "made")
    assert page.count("<circle") == sum(e.kind != "phase" for e in events)
    assert page.count("<rect") >= sum(e.kind == "phase" for e in events) > 0
    for phase in {e.name.replace("_", " ") for e in events if e.kind == "phase"}:
        assert re.search(rf"<text [^>]*>{phase}</text>", page), f"{phase} has no room for its name"
    for target in made.recorded.assists[-1].value:
        assert target.target_id in words
    assert run(report, monkeypatch, str(made_bag), "--out", str(out)) == 2


def test_a_report_shows_names_as_text_whatever_they_are(tmp_path: Path):
    recorded = session("<script>alert(1)</script>", np.random.default_rng(0)).recorded
    with BagWriter(tmp_path / "bag") as writer:
        session_to_bag(recorded, writer)
    bag = Bag(tmp_path / "bag")
    assert "<script" not in report.report_html(bag, session_from_bag(bag))


def test_many_bags_are_computed_by_processes_in_order_and_a_bad_one_spoils_no_other(study: Path, tmp_path: Path):
    bad = tmp_path / "bad"
    bad.mkdir()
    (bad / "metadata.yaml").write_text("a: [")
    paths = [*bags_below([study]), bad]
    alone = list(check_bags(paths, RecomputeFrom.ASSISTS, LocalProcesses(1)))
    together = list(check_bags(paths, RecomputeFrom.ASSISTS, LocalProcesses(2)))
    assert [c.path for c in together] == [c.path for c in alone] == paths
    assert [c.agrees for c in together] == [c.agrees for c in alone] == [True] * 5 + [False]
    assert re.search("metadata.yaml", together[-1].failure)
    assert len(paths) == 6
    assert len(list(bags_below([study], superseded=True))) == 6
    with pytest.raises(BagError, match="no bag in or below"):
        list(bags_below([_empty(tmp_path)]))


def _empty(folder: Path) -> Path:
    (folder / "empty").mkdir()
    return folder / "empty"
