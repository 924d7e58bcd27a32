"""A shared copy computes to the same estimates, and holds no picture, no note and no old name."""

from __future__ import annotations

import csv
import sys
from array import array
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.ros.session_conversions import session_from_bag, session_to_bag
from mbd_bag.session.recorded_session import Recorded, RecordedReply
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_model.parallel.local_processes import LocalProcesses
from mbd_study.recompute.reevaluate_command import check_bags
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.sharing import share_command
from mbd_study.sharing.names import NameFinder
from mbd_study.sharing.pseudonyms import new_participants
from mbd_study.sharing.rules import KEPT_TYPES, SharedPictures, why_left_out
from mbd_study.sharing.shared_copy import Omissions, shared_copy
from mbd_study.synthetic import CAMERA, session

SECRETS = (b"annak", b"Bernd", b"blue jacket")


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["share", *words])
    with pytest.raises(SystemExit) as ended:
        share_command.main()
    return int(ended.value.code)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sessions of two people, with a note, its reply, a parameter that names one, and a film of the room."""
    folder = tmp_path_factory.mktemp("study")
    for number, person in enumerate(("annak", "bernd")):
        made = session(f"{person}_mbd_sorting", np.random.default_rng(number))
        at = made.recorded.prompts[0].log_time
        recorded = replace(
            made.recorded,
            facts=dict(made.recorded.facts)
            | {"participant": person, "parameter./console.title": f"'{person}'", "operator": "Bernd"},
            notes=(Recorded("Bernd wears a blue jacket", at, at),),
            replies=(Recorded(RecordedReply("wizard/note", True, "noted: blue jacket"), at, at),),
        )
        path = folder / person / "bag"
        path.parent.mkdir()
        with BagWriter(path) as bag:
            session_to_bag(recorded, bag, made.pictures, CAMERA)
        (path.parent / "room.webm").write_bytes(b"film")
    return folder


def held(folder: Path) -> bytes:
    """Every byte a reader gets of the bags below a folder, uncompressed, with their facts and paths."""
    parts = []
    for path in sorted(folder.rglob("metadata.yaml")):
        bag = Bag(path.parent)
        parts += [bytes(m.data) for m in bag.messages()]
        parts += [repr(bag.facts).encode(), path.read_bytes(), str(path.relative_to(folder)).encode()]
    return b"\n".join(parts)


def test_a_copy_holds_no_secret_computes_the_same_and_says_what_it_lacks(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    assert all(secret in held(study) for secret in SECRETS)
    before = held(study)
    out, key = tmp_path / "shared", tmp_path / "key.csv"
    assert run(monkeypatch, str(study), "--out", str(out), "--key", str(key)) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert [secret for secret in (*SECRETS, b"bernd") if secret in held(out)] == []
    assert held(study) == before
    for said in ("/wizard/note, 2 messages: free text", "image_raw", "room.webm", "operator", "date of each session"):
        assert said in words
    assert not list(out.rglob("*.webm"))
    copies = sorted(out.glob("*/bag"))
    assert [c.agrees for c in check_bags(copies, RecomputeFrom.ASSISTS, LocalProcesses(1))] == [True, True]
    with key.open(newline="") as stream:
        rows = {r["session"]: r for r in csv.DictReader(stream)}
    for name, row in rows.items():
        old = session_from_bag(Bag(study / name.partition("_")[0] / "bag"))
        new = session_from_bag(Bag(out / row["shared_session"] / "bag"))
        assert new.name == row["shared_session"]
        assert new.facts["participant"] == row["shared_participant"]
        assert [e[0].value for e in new.estimates] == [e[0].value for e in old.estimates]
        assert new.assists == old.assists
        assert new.notes == ()
    assert run(monkeypatch, str(study), "--out", str(out)) == 2


def test_pictures_are_kept_on_request_and_planned_sessions_keep_condition_and_task(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    plan = tmp_path / "plan.yaml"
    plan.write_text("study: s\nseed: 1\nconditions: [mbd]\ntasks: [sorting]\nparticipants: [annak, bernd]\n")
    out = tmp_path / "shared"
    assert (
        run(monkeypatch, str(study), "--out", str(out), "--cameras", "whole", "--plan", str(plan), "--seed", "1") == 0
    )
    assert "look at each for faces" in " ".join(capsys.readouterr().out.split())
    names = sorted(p.name for p in out.iterdir())
    assert [n.partition("_")[2] for n in names] == ["mbd_sorting"] * 2
    assert any("image" in t.name and t.count for t in Bag(out / names[0] / "bag").topics)
    # Of these sessions nobody says where the camera stood.
    assert run(monkeypatch, str(study), "--out", str(tmp_path / "covered"), "--cameras") == 0
    assert "does not say where the camera stood" in " ".join(capsys.readouterr().out.split())


def test_a_key_is_never_written_among_the_copies_and_a_bad_bag_is_named(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    out = tmp_path / "shared"
    assert run(monkeypatch, str(study), "--out", str(out), "--key", str(out / "key.csv")) == 2
    assert not out.exists()
    assert run(monkeypatch, str(study), "--out", str(study / "annak" / "room.webm" / "shared")) == 2
    assert "choose another" in " ".join(capsys.readouterr().err.split())
    bad = tmp_path / "bad"
    bad.mkdir()
    (bad / "metadata.yaml").write_text("a: [")
    assert run(monkeypatch, str(study / "annak"), str(bad), "--out", str(out)) == share_command.INCOMPLETE
    assert "is not copied" in " ".join(capsys.readouterr().out.split())
    assert len(list(out.iterdir())) == 1


@given(st.sets(st.from_regex(r"[a-z]\d{1,2}", fullmatch=True), min_size=1, max_size=20), st.integers(0, 99))
def test_new_pseudonyms_are_distinct_and_none_is_an_old_one(old: set[str], seed: int):
    new = new_participants(sorted(old), np.random.default_rng(seed))
    assert set(new) == old
    assert len(set(new.values())) == len(old)
    assert not old & set(new.values())


def test_a_type_nobody_looked_at_is_left_out():
    assert why_left_out("mbd_msgs/msg/FormAnswers", SharedPictures.TABLE)
    assert why_left_out("audio_common_msgs/msg/AudioData", SharedPictures.TABLE)
    assert why_left_out("sensor_msgs/msg/Image", SharedPictures.NONE)
    assert not why_left_out("sensor_msgs/msg/Image", SharedPictures.TABLE)


def planted(kind: str, text: str) -> Any:
    """A message with a text in every field that can hold one, one message in every list of messages."""
    package, folder, name = kind.split("/")
    message = getattr(import_module(f"{package}.{folder}"), name)()
    for field, type_name in message.get_fields_and_field_types().items():
        element = type_name.removeprefix("sequence<").partition(",")[0].rstrip(">")
        value = getattr(message, field)
        if element == "string":
            setattr(message, field, text if isinstance(value, str) else [text])
        elif hasattr(value, "get_fields_and_field_types"):
            setattr(message, field, planted("/msg/".join(element.split("/")), text))
        elif "/" in element and not isinstance(value, array | np.ndarray):
            one = planted("/msg/".join(element.split("/")), text)
            setattr(message, field, [one] * max(1, len(value)))
    return message


def copy_of_planted(text: str, folder: Path, names: tuple[str, ...], person: str = "") -> tuple[bytes, Omissions]:
    """What a reader gets of the copy of a bag with a text in every field, one message of each kept type in it."""
    kinds = sorted(kind for kind in KEPT_TYPES if kind.split("/")[0] not in ("tf2_msgs", "rosgraph_msgs"))
    with BagWriter(folder / "bag") as bag:
        bag.add_facts({"session": "p07_sorting", "participant": person, "operator": text, "parameter./a.b": text})
        writer = MessageWriter(bag)
        for number, kind in enumerate(kinds):
            message = planted(kind, text)
            if kind == "mbd_msgs/msg/Scene":
                # Perception's ids are its own, never a person's words.
                message.objects[0].id = "s1"
            if kind == "mbd_msgs/msg/Task":
                message.source.objects[0].id = "s1"
            writer.write(f"/topic{number}", message, 10**9 + number)
        if person:
            writer.write(f"/{text}/scene", planted("mbd_msgs/msg/Scene", "s1"), 2 * 10**9)
    source = Bag(folder / "bag")
    assert sum(bytes(m.data).count(text.encode()) for m in source.messages()) > 60
    out = folder / "shared" / "a01" / "bag"
    omitted = shared_copy(source, out, session="a01_01", participant="a01", names=names)
    assert sum(t.count for t in Bag(out).topics) == len(kinds)
    return held(folder / "shared"), omitted


def test_a_known_name_is_in_no_byte_of_the_copy_whatever_field_it_stood_in(tmp_path: Path):
    copy, omitted = copy_of_planted("Annak", tmp_path, (), "annak")
    assert b"annak" not in copy.lower()
    assert omitted.blanked["Prompt.text"] == 1
    assert [key for key in omitted.blanked if "__" in key] == []
    assert omitted.topics["/[name]/scene"][0] == "its topic holds a name"


def test_a_listed_name_is_found_as_part_of_a_sentence_and_in_any_case(tmp_path: Path):
    copy, _ = copy_of_planted("Frau MÜLLER, Zoë's friend", tmp_path, ("müller", "zoë"))
    text = copy.decode(errors="replace").lower()
    assert "müller" not in text
    assert "zoë" not in text


def test_an_unknown_text_stays_only_where_the_robots_set_up_has_words(tmp_path: Path):
    text = "blue jacket"
    copy_of_planted(text, tmp_path, ())
    bag = Bag(tmp_path / "shared" / "a01" / "bag")
    kept = {m.msgtype.rpartition("/")[2] for m in bag.messages() if text.encode() in bytes(m.data)}
    # Whatever else they hold, each of these has a header with the name of a frame, or is about the set-up.
    for kind in ("WizardReply", "SessionState", "Stop", "WizardHanded", "WizardPointed", "WizardOverwrite"):
        (message,) = (d for m, d in bag.decoded({t.name for t in bag.topics}) if m.msgtype.endswith(f"/{kind}"))
        texts = {n: v for n, v in vars(message).items() if isinstance(v, str) and text in v}
        assert set(texts) <= {"topic"}, kind
    assert "CellTruth" in kept


@given(st.text("abnxyz_ .", max_size=40), st.sampled_from(["anna", "Ben", "p01"]), st.text("abnxyz_ .", max_size=10))
def test_no_name_is_left_in_a_text_and_other_words_stay(before: str, name: str, after: str):
    finder = NameFinder([name, "", " "])
    clean = finder.without(f"{before} {name.upper()} {after}")
    assert not finder.within(clean)
    assert finder.without("annalen") == "annalen"
    assert finder.maybe_in(f"{before} {name} {after}".encode())
    assert NameFinder([]).without(before) == before
