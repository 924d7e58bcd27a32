"""Annotations survive ELAN's files to the millisecond, and kappa is what Cohen defined, over time."""

from __future__ import annotations

import csv
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.storage.bag import Bag
from mbd_model.times import to_seconds
from mbd_study.annotation import elan_command
from mbd_study.annotation.agreement import agreement
from mbd_study.annotation.elan_file import AnnotationError, read_eaf, write_eaf
from mbd_study.annotation.intervals import Interval, by_tier, session_intervals
from mbd_study.tables.events import event_rows

BAG = Path(__file__).resolve().parents[2] / "bags" / "stacking_undo"
# One label a second: as a list, and as intervals.
CODED = st.lists(st.sampled_from("abc"), min_size=1, max_size=30)


def intervals(labels: list[str], tier: str = "code") -> list[Interval]:
    return [Interval(tier, float(k), k + 1.0, label) for k, label in enumerate(labels)]


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["elan", *words])
    with pytest.raises(SystemExit) as ended:
        elan_command.main()
    return int(ended.value.code)


@given(st.lists(st.tuples(CODED, CODED), min_size=1, max_size=1))
def test_kappa_over_time_is_that_of_equally_long_samples(pairs: list[tuple[list[str], list[str]]]):
    one, other = pairs[0]
    count = min(len(one), len(other))
    one, other = one[:count], other[:count]
    found = agreement(intervals(one), intervals(other), float(count))
    observed = sum(a == b for a, b in zip(one, other, strict=True)) / count
    first, second = Counter(one), Counter(other)
    expected = sum(first[label] * second[label] for label in first) / count**2
    assert found.observed == pytest.approx(observed)
    assert found.expected == pytest.approx(expected)
    if expected < 1:
        assert found.kappa == pytest.approx((observed - expected) / (1 - expected))
    else:
        assert found.kappa is None


def test_a_published_example_of_cohens_kappa_comes_out():
    # Two readers of 50 proposals: both yes 20, first only 5, second only 10, both no 15; kappa 0.4.
    one = [*"y" * 25, *"n" * 25]
    other = [*"y" * 20, *"n" * 5, *"y" * 10, *"n" * 15]
    assert agreement(intervals(one), intervals(other), 50.0).kappa == pytest.approx(0.4)


def test_what_only_one_annotated_counts_as_disagreement():
    found = agreement(intervals(["a"]), intervals(["a", "a"]), 2.0)
    assert found.observed == pytest.approx(0.5)
    assert found.seconds == {("a", "a"): 1.0, ("-", "a"): 1.0}


def test_a_session_comes_back_from_elan_as_it_was_and_no_tier_overlaps(tmp_path: Path):
    bag = Bag(BAG)
    made = session_intervals(event_rows(bag, "s"), to_seconds(bag.end - bag.start))
    write_eaf(tmp_path / "s.eaf", made, ["code"])
    back = by_tier(read_eaf(tmp_path / "s.eaf"))
    assert set(back) == set(by_tier(made)) >= {"phase", "robot", "operator", "notes", "refused"}
    for tier, own in by_tier(made).items():
        assert [i.label for i in back[tier]] == [i.label for i in own]
        assert [i.start for i in back[tier]] == pytest.approx([i.start for i in own], abs=6e-4)
        assert all(a.end <= b.start for a, b in pairwise(back[tier]))
    with pytest.raises(AnnotationError, match="not overwritten"):
        write_eaf(tmp_path / "s.eaf", made)


def test_the_command_writes_reads_and_compares(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    eaf = tmp_path / "s.eaf"
    assert run(monkeypatch, "write", str(BAG), "--out", str(eaf), "--tier", "code") == 0
    for name, labels in (("x", "aabb"), ("y", "aabc")):
        write_eaf(tmp_path / f"{name}.eaf", intervals(list(labels)))
    out = tmp_path / "annotations.csv"
    assert run(monkeypatch, "read", str(tmp_path / "x.eaf"), str(tmp_path / "y.eaf"), "--out", str(out)) == 0
    with out.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(r["file"], r["label"]) for r in rows] == [(n, c) for n, s in (("x", "aabb"), ("y", "aabc")) for c in s]
    assert run(monkeypatch, "agree", str(tmp_path / "x.eaf"), str(tmp_path / "y.eaf"), "--tier", "code") == 0
    assert "kappa 0.600" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["", "<a/>", "no xml", "<ANNOTATION_DOCUMENT/>"])
def test_what_is_no_file_of_elans_is_refused_by_name(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    path = tmp_path / "bad.eaf"
    path.write_text(text)
    assert run(monkeypatch, "read", str(path), "--out", str(tmp_path / "t.csv")) == 2
    assert "no file of ELAN's" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "t.csv").exists()


def test_a_tier_that_is_not_there_is_named_with_the_nearest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    path = tmp_path / "x.eaf"
    write_eaf(path, intervals(["a"]))
    assert run(monkeypatch, "agree", str(path), str(path), "--tier", "cod") == 2
    assert "did you mean 'code'" in " ".join(capsys.readouterr().err.split())
