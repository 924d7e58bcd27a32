"""Events are in true order, causes before what they cause; tables come with a dictionary that other programs check."""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

import pandas as pd
import pytest
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import type_hash
from mbd_study.tables import export
from mbd_study.tables.data_dictionary import DICTIONARY
from mbd_study.tables.events import EventRow, event_rows, event_topics

BAGS = Path(__file__).resolve().parents[2] / "bags"
NAMES = ("stacking_undo", "sorting")


@pytest.fixture(scope="module", params=NAMES)
def events(request: pytest.FixtureRequest) -> tuple[Bag, tuple[EventRow, ...]]:
    bag = Bag(BAGS / request.param)
    return bag, event_rows(bag, request.param)


def test_every_word_and_reply_of_a_bag_is_a_row_and_times_are_the_bags(events: tuple[Bag, tuple[EventRow, ...]]):
    bag, rows = events
    counts = {t.name: t.count for t in bag.topics if t.name in event_topics(bag)}
    said = sum(n for topic, n in counts.items() if "/wizard/" in topic)
    assert sum(r.kind in ("word", "note") for r in rows) == said > 5
    assert sum(r.kind == "reply" for r in rows) == counts["/interaction/replies"]
    assert sum(r.kind == "prompt" for r in rows) == counts["/interaction/prompt"]
    assert [r.event for r in rows] == list(range(len(rows)))
    # A reply that was recorded before its word is the only thing that may go back.
    assert all(b.time_s >= a.time_s for a, b in pairwise(rows) if a.kind not in ("word", "note"))


def test_a_cause_comes_before_what_it_causes_and_each_reply_has_the_word_of_its_topic(
    events: tuple[Bag, tuple[EventRow, ...]],
):
    _, rows = events
    replies = [r for r in rows if r.kind == "reply"]
    assert all(r.cause is not None and r.cause < r.event for r in replies)
    assert len({r.cause for r in replies}) == len(replies)
    for reply in replies:
        assert rows[reply.cause].topic == reply.topic
    words = [r for r in rows if r.kind == "word" and r.cause is not None]
    answers = [r for r in words if r.topic in ("wizard/handed", "wizard/pointed", "wizard/answer")]
    assert answers
    assert all(rows[a.cause].kind == "prompt" for a in answers)
    assert all(rows[w.cause].kind == "speech" for w in words if w not in answers)
    assert all(w.latency_s >= 0 for w in words)


def test_notes_refusals_and_withdrawals_are_told_by_name():
    rows = event_rows(Bag(BAGS / "stacking_undo"), "stacking_undo")
    (note,) = (r for r in rows if r.kind == "note")
    assert "take it back" in note.text
    refused = [r for r in rows if r.accepted is False]
    assert [r.topic for r in refused] == ["wizard/pointed"]
    assert "undo" in {r.name for r in rows if r.topic == "wizard/command"}
    phases = [r.name for r in rows if r.kind == "phase"]
    assert phases[0] == "observe_source"
    assert phases[-1] == "done"


def test_a_reply_recorded_before_its_word_comes_after_it(tmp_path: Path):
    bag = Bag(BAGS / "stacking_undo")
    messages = list(bag.messages(set(event_topics(bag))))
    # The third reply, two seconds before its word.
    early = [m for m in messages if m.topic == "/interaction/replies"][2]
    messages = [replace(m, log_time=m.log_time - 2 * 10**9) if m is early else m for m in messages]
    with BagWriter(tmp_path / "skewed") as copy:
        for topic in bag.topics:
            record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), bag.offered_qos(topic.name))
            copy.add_topic(record, bag.decoder.texts[topic.msgtype])
        for message in sorted(messages, key=lambda m: m.log_time):
            copy.write(message.topic, message.log_time, message.data)
    rows = event_rows(Bag(tmp_path / "skewed"), "s")
    assert len(rows) == len(event_rows(bag, "s"))
    assert all(r.cause is not None and r.cause < r.event for r in rows if r.kind == "reply")
    assert [r.latency_s for r in rows if r.kind == "reply"][2] == pytest.approx(-2.0, abs=0.2)


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tables") / "out"
    words = ["export", *(str(BAGS / n) for n in NAMES), "--out", str(out), "--parquet", "--jobs", "1"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", words)
        with pytest.raises(SystemExit) as ended:
            export.main()
    assert ended.value.code == 0
    return out


def test_each_column_is_in_the_dictionary_and_nothing_else():
    for name, row in export.TABLES.items():
        assert list(DICTIONARY[name]) == [f.name for f in fields(row)]
    assert set(DICTIONARY) == set(export.TABLES)


def test_the_data_package_is_valid_by_frictionless_and_a_wrong_cell_is_not(tables: Path):
    frictionless = pytest.importorskip("frictionless")
    report = frictionless.validate(tables / "datapackage.json")
    assert report.valid, report.flatten(["title", "message"])
    assert len(report.tasks) == len(export.TABLES)
    path = tables / "steps.csv"
    good = path.read_text()
    path.write_text(good.replace(",pick,", ",pick,,,", 1))
    assert not frictionless.validate(tables / "datapackage.json").valid
    path.write_text(good)


def test_pandas_reads_the_same_from_csv_and_parquet_one_correspondence_a_row(tables: Path):
    for name in export.TABLES:
        text, typed = pd.read_csv(tables / f"{name}.csv"), pd.read_parquet(tables / f"{name}.parquet")
        assert list(text.columns) == list(typed.columns) == list(DICTIONARY[name])
        assert len(text) == len(typed)
        # Nobody fills in a form for these, and marks nothing.
        assert len(text) > 0 or name in ("markers", "forms", "scores")
    pairs, estimates = (pd.read_parquet(tables / f"{n}.parquet") for n in ("correspondences", "estimates"))
    own = pairs[pairs["mapping"] == "prediction"]
    text = (own["source"] + ">" + own["target"]).groupby([own["session"], own["estimate"]]).agg(" ".join)
    named = estimates[estimates["mapping"] != ""].set_index(["session", "estimate"])["mapping"]
    assert text.to_dict() == named.to_dict()
    events = pd.read_csv(tables / "events.csv")
    latency = events[events["kind"] == "word"].groupby("session")["latency_s"].median()
    assert set(latency.dropna().index) <= set(NAMES)
    assert events["accepted"].dropna().isin([True, False]).all()
