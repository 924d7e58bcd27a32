"""Forms and markers are rows: an answer each; what was sent in again does not count; who took how long is seen."""

from __future__ import annotations

import csv
import math
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from mbd_bag.session.command_line import open_session
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import type_hash
from mbd_bag.storage.message_writer import EVENTS, MessageWriter
from mbd_model.ros.conversions import stamp_to_msg
from mbd_msgs import msg as m
from mbd_study.tables import export
from mbd_study.tables.events import event_rows
from mbd_study.tables.table_rows import SessionTables, session_tables
from std_msgs.msg import Header

BAGS = Path(__file__).resolve().parents[2] / "bags"
SECOND = 1_000_000_000
NAN = math.nan


def answer(item: str, kind: int, value: str, number: float, answered: bool = True) -> m.FormAnswer:
    return m.FormAnswer(
        item=item, kind=kind, text=f"{item}, in words?", answered=answered, value=value, shown=value, number=number
    )


def form(at: int, name: str, *answers: m.FormAnswer, declined: bool = False, sus: float | None = None) -> m.FilledForm:
    """Sent in at a time [ns], 30 s after it was opened."""
    scores = [] if sus is None else [m.FormScore(name="sus", value=sus)]
    opened, header = stamp_to_msg(at - 30 * SECOND), Header(stamp=stamp_to_msg(at))
    head = {"header": header, "opened": opened, "phase": 5, "form": name, "version": "1", "language": "de"}
    return m.FilledForm(**head, declined=declined, answers=list(answers), scores=scores)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sample bag, and in it when the teacher acted, a quote, and forms."""
    source = Bag(BAGS / "stacking_undo")
    # Its own notes are of an older definition, which knows no markers.
    messages = [x for x in source.messages() if x.topic != "/wizard/note"]
    rows = event_rows(source, "stacking_undo")
    answered = next(r for r in rows if r.topic in ("wizard/handed", "wizard/pointed") and r.latency_s)
    acted = source.start + round((answered.time_s - answered.latency_s / 2) * SECOND)
    end = source.end
    made: list[tuple[int, str, object]] = [
        (acted, "/wizard/note", m.WizardNote(marker="teacher_acts")),
        (acted, "/wizard/note", m.WizardNote(text='she, was "sure"\nof it', marker="quote")),
        (end - 9 * SECOND, "/study/form", form(end - 9 * SECOND, "consent", declined=True)),
        (end - 8 * SECOND, "/study/form", form(end - 8 * SECOND, "sus", answer("sus1", 3, "2", 2.0), sus=30.0)),
        (
            end - 2 * SECOND,
            "/study/form",
            form(
                end - 2 * SECOND,
                "sus",
                answer("sus1", 3, "5", 5.0),
                answer("sus2", 3, "", NAN, answered=False),
                answer("why", 1, 'Größe, 漢字; a "b"\nc', NAN),
                answer("again", 5, "no", 0.0),
                sus=87.5,
            ),
        ),
    ]
    made.sort(key=lambda one: one[0])
    folder = tmp_path_factory.mktemp("study") / "stacking_undo"
    with BagWriter(folder) as bag:
        bag.add_facts(dict(source.facts) | {"plan.condition": "mbd", "plan.position": "2"})
        for topic in (t for t in source.topics if t.name != "/wizard/note"):
            record = TopicRecord(topic.name, topic.msgtype, type_hash(topic.msgtype), source.offered_qos(topic.name))
            bag.add_topic(record, source.decoder.texts[topic.msgtype])
        writer = MessageWriter(bag)
        for message in messages:
            while made and made[0][0] <= message.log_time:
                time, topic, added = made.pop(0)
                writer.write(topic, added, time, EVENTS)
            bag.write(message.topic, message.log_time, message.data)
    return folder


@pytest.fixture(scope="module")
def tables(study: Path) -> SessionTables:
    return session_tables(*open_session(study))


def test_each_answer_is_a_row_and_a_form_sent_in_again_supersedes_the_one_before(tables: SessionTables):
    assert [(r.form, r.filling, r.superseded, r.item) for r in tables.forms] == [
        ("consent", 0, False, ""),
        ("sus", 1, True, "sus1"),
        *(("sus", 2, False, item) for item in ("sus1", "sus2", "why", "again")),
    ]
    by_item = {r.item: r for r in tables.forms if r.filling == 2}
    assert [by_item[i].number for i in ("sus1", "sus2", "why", "again")] == [5.0, None, None, 0.0]
    assert [by_item[i].kind for i in ("sus1", "sus2", "why", "again")] == ["scale", "scale", "text", "yes_no"]
    assert not by_item["sus2"].answered
    assert tables.forms[0].declined
    assert all(r.opened_s == pytest.approx(r.sent_s - 30.0) for r in tables.forms)
    assert [(s.superseded, s.value) for s in tables.scores] == [(True, 30.0), (False, 87.5)]


def test_markers_are_rows_and_part_an_answers_latency_into_the_teachers_and_the_operators(tables: SessionTables):
    assert [r.name for r in tables.markers] == ["teacher_acts", "quote"]
    (parted,) = (e for e in tables.events if e.teacher_latency_s is not None)
    assert parted.wizard_latency_s == pytest.approx(parted.latency_s / 2, abs=1e-6)
    assert parted.teacher_latency_s + parted.wizard_latency_s == pytest.approx(parted.latency_s)
    assert tables.events[parted.cause].kind == "prompt"
    assert [e.name for e in tables.events if e.kind == "form"] == ["declined", "sent", "sent"]


def test_a_word_that_follows_the_simulated_teachers_speech_has_the_operators_latency(tables: SessionTables):
    spoken = [
        e for e in tables.events if e.kind == "word" and e.cause is not None and tables.events[e.cause].kind == "speech"
    ]
    assert {e.name for e in spoken} >= {"open", "close"}
    assert all(e.wizard_latency_s == e.latency_s >= 0 for e in spoken)
    assert all(tables.events[e.cause].time_s <= e.time_s for e in spoken)


def test_the_plans_words_stand_in_the_table_of_sessions(tables: SessionTables):
    (row,) = tables.sessions
    assert (row.condition, row.position, row.deviation) == ("mbd", "2", "")


R = r"""
options(digits = 15)
folder <- commandArgs(TRUE)[1]
for (name in sub("\\.csv$", "", sort(list.files(folder, pattern = "\\.csv$")))) {
  table <- read.csv(file.path(folder, paste0(name, ".csv")), encoding = "UTF-8")
  cat(name, nrow(table), ncol(table), "\n")
}
forms <- read.csv(file.path(folder, "forms.csv"), encoding = "UTF-8")
estimates <- read.csv(file.path(folder, "estimates.csv"), encoding = "UTF-8")
events <- read.csv(file.path(folder, "events.csv"), encoding = "UTF-8")
cat("why", utf8ToInt(forms$value[forms$item == "why"]), "\n")
cat("classes", class(estimates$confidence), class(estimates$confident), class(events$latency_s), "\n")
cat("means", mean(estimates$confidence), mean(events$latency_s, na.rm = TRUE), mean(forms$number, na.rm = TRUE), "\n")
"""


def test_r_and_pandas_read_the_same_from_every_table(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / "tables"
    monkeypatch.setattr(sys, "argv", ["export", str(study), "--out", str(out), "--jobs", "1"])
    with pytest.raises(SystemExit) as ended:
        export.main()
    assert ended.value.code == 0
    read = {name: pd.read_csv(out / f"{name}.csv") for name in export.TABLES}
    with (out / "forms.csv").open(newline="", encoding="utf-8") as stream:
        (why,) = (row["value"] for row in csv.DictReader(stream) if row["item"] == "why")
    assert why == 'Größe, 漢字; a "b"\nc'
    rscript = shutil.which("Rscript")
    if rscript is None:
        pytest.skip("Rscript is not installed (Debian: r-base-core); pandas has read the tables")
    (tmp_path / "read.R").write_text(R)
    done = subprocess.run([rscript, "--vanilla", tmp_path / "read.R", out], capture_output=True, text=True, check=True)
    said = {line.split()[0]: line.split()[1:] for line in done.stdout.splitlines()}
    for name, table in read.items():
        assert [int(v) for v in said[name]] == list(table.shape)
    assert "".join(chr(int(v)) for v in said["why"]) == why
    assert said["classes"] == ["numeric", "character", "numeric"]
    means = (read["estimates"]["confidence"], read["events"]["latency_s"], read["forms"]["number"])
    assert [float(v) for v in said["means"]] == pytest.approx([table.mean() for table in means])
