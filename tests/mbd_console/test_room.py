"""Films of the room: who may send them, what is kept of them, and what is refused with one sentence."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_console import state as console_state
from mbd_console.access.gate import AccessGate
from mbd_console.access.headers import SecurityHeaders
from mbd_console.access.rule import AccessRule
from mbd_console.requests import WriteNote
from mbd_console.room.panel import SAID, room_panel
from mbd_console.room.refusal import RoomRefusedError
from mbd_console.room.routes import room_routes
from mbd_console.room.shown import ShownFilm, room_lamp, room_sentence
from mbd_console.room.store import ABANDONED, LARGEST_CHUNK, LARGEST_RATE, MOST_OPEN, WEBM, RoomStore
from mbd_console.state import ConsoleState
from mbd_console.words.texts import ENGLISH, LANGUAGES, PageTexts
from mbd_model.room.device_report import DeviceReport
from mbd_model.room.recording import SIGNAL_MARKER, RoomError, read_room_recording, room_recording
from mbd_model.session import Phase, SessionState

TOKEN, OBSERVER = "a token nobody guesses", "another that observers know"
NOW = 1000.0
FACTS: dict[str, Any] = {"started": 2.0, "clock": [[1.0, 999.0, 0.001]], "signals": [[1, 1.75, 0.03]], "ended": False}


class Room:
    """A store behind its addresses, with a clock, a disk and a recorder that a test sets."""

    def __init__(self, folder: Path | None, rule: AccessRule | None = None) -> None:
        self.time, self.free, self.records = 0.0, 1e12, True
        self.notes: list[WriteNote] = []
        self.store = RoomStore(folder, lambda: self.time, lambda _: self.free)
        app = FastAPI()
        app.include_router(room_routes(self.store, lambda: NOW, self.notes.append, lambda: self.records))
        app.add_middleware(AccessGate, rule=rule or AccessRule("127.0.0.1", ""))
        self.client = TestClient(app, base_url="http://127.0.0.1:8080", raise_server_exceptions=False)

    def begin(self) -> tuple[str, str]:
        begun = self.client.post("/room/begin", json={}).json()
        return begun["name"], begun["key"]

    def chunk(self, name: str, number: int, data: bytes, key: str, kind: str = "video/webm") -> Any:
        headers = {"content-type": kind, "x-room-key": key}
        return self.client.post(f"/room/{name}/{number}", content=data, headers=headers)


def test_chunks_become_one_file_and_the_next_film_another(tmp_path: Path):
    room = Room(tmp_path)
    (tmp_path / "room_1.webm").write_bytes(b"of before")
    name, key = room.begin()
    assert [room.chunk(name, k, data, key).json()["size"] for k, data in enumerate((WEBM + b"a", b"bc"))] == [5, 7]
    assert (tmp_path / "room_2.webm").read_bytes() == WEBM + b"abc"
    assert (tmp_path / "room_1.webm").read_bytes() == b"of before"
    assert room.begin()[0] == "room_3"
    assert [film.name for film in room.store.shown] == ["room_2", "room_3"]


@settings(max_examples=40)
@given(chunks=st.lists(st.binary(min_size=1, max_size=20), max_size=6), order=st.lists(st.integers(-1, 7), max_size=20))
def test_whatever_comes_twice_or_too_early_the_file_is_what_came_in_turn(
    tmp_path_factory: pytest.TempPathFactory, chunks: list[bytes], order: list[int]
):
    chunks = [WEBM, *chunks]
    store = RoomStore(tmp_path_factory.mktemp("film"), lambda: 0.0)
    name, key = store.begin()
    taken = 0
    for number in order:
        if not 0 <= number < len(chunks):
            continue
        if number > taken:
            with pytest.raises(RoomRefusedError, match="missing"):
                store.append(name, key, number, chunks[number])
            continue
        store.append(name, key, number, chunks[number])
        taken = max(taken, number + 1)
    assert store.folder is not None
    assert (store.folder / "room_1.webm").read_bytes() == b"".join(chunks[:taken])


OTHERS: list[tuple[dict[str, str], int]] = [
    ({}, 401),
    ({"cookie": "mbd_console=guessed"}, 401),
    ({"origin": "http://evil.example"}, 403),
]


@pytest.mark.parametrize(("headers", "status"), OTHERS)
def test_who_did_not_sign_in_as_the_operator_writes_nothing(tmp_path: Path, headers: dict[str, str], status: int):
    room = Room(tmp_path, AccessRule("0.0.0.0", TOKEN, OBSERVER))
    for path in ("begin", "room_1/0", "room_1"):
        assert room.client.post(f"/room/{path}", headers=headers).status_code == status
    assert list(tmp_path.iterdir()) == []


def test_an_observer_films_nothing_and_the_operator_does(tmp_path: Path):
    room = Room(tmp_path, AccessRule("0.0.0.0", TOKEN, OBSERVER))
    for token, status in ((OBSERVER, 403), (TOKEN, 200)):
        room.client.cookies.clear()
        room.client.post("/sign_in", data={"token": token}, follow_redirects=False)
        assert room.client.get("/room/clock").status_code == status
        assert room.client.post("/room/begin", json={}).status_code == status


HOSTILE: list[tuple[Callable[[Room, str, str], Any], int, str]] = [
    (lambda r, n, k: r.chunk(n, 0, b"no film", k), 415, "no WebM"),
    (lambda r, n, k: r.chunk(n, 0, WEBM, k, "text/plain"), 415, "expected video/webm"),
    (lambda r, n, k: r.chunk(n, 1, WEBM, k), 409, "missing"),
    (lambda r, n, k: r.chunk(n, 0, WEBM, "guessed"), 404, "no such recording"),
    (lambda r, n, k: r.chunk(n, 0, WEBM, ""), 404, "no such recording"),
    (lambda r, n, k: r.chunk("room_7", 0, WEBM, k), 404, "no such recording"),
    (lambda r, n, k: r.chunk("..%2f..%2fetc", 0, WEBM, k), 404, ""),
    (lambda r, n, k: r.chunk(n, -1, b"more", k), 200, ""),  # as one that came already: nothing is added
    (lambda r, n, k: r.chunk(n, 0, WEBM + bytes(LARGEST_CHUNK), k), 413, "8 MB"),
    (lambda r, n, k: r.client.post(f"/room/{n}", content=b"{", headers={"content-type": "application/json"}), 422, "?"),
    (lambda r, n, k: r.client.post(f"/room/{n}", json={**FACTS, "key": "x"}), 404, "no such recording"),
    (lambda r, n, k: r.client.post(f"/room/{n}", json={**FACTS, "key": k, "clock": [[1, "x", 3]]}), 422, "clock"),
    (lambda r, n, k: r.client.post(f"/room/{n}", content=b"[" * 10**5, headers={"content-type": "application/json"}),
     422, "?"),
]  # fmt: skip


@pytest.mark.parametrize(("send", "status", "why"), HOSTILE)
def test_what_is_no_part_of_a_film_is_refused_and_leaves_it_as_it_is(
    tmp_path: Path, send: Callable[[Room, str, str], Any], status: int, why: str
):
    room = Room(tmp_path)
    name, key = room.begin()
    answer = send(room, name, key)
    assert answer.status_code == status
    assert why in ("", "?") or why in answer.json()["why"]
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("room_1.webm", b"")]
    assert room.chunk(name, 0, WEBM, key).status_code == 200


def test_a_film_that_comes_too_fast_waits_and_too_many_are_refused(tmp_path: Path):
    room = Room(tmp_path)
    name, key = room.begin()
    part = WEBM + bytes(LARGEST_CHUNK - len(WEBM))
    number = 0
    while room.store.append(name, key, number, part) <= LARGEST_RATE - len(part):
        number += 1
    assert room.chunk(name, number + 1, part, key).status_code == 429
    room.time = 61.0
    assert room.chunk(name, number + 1, b"later", key).status_code == 200
    opened = [room.begin() for _ in range(MOST_OPEN - 1)]
    refused = room.client.post("/room/begin", json={})
    assert (refused.status_code, len(opened)) == (409, MOST_OPEN - 1)
    room.time += ABANDONED + 1  # their pages are gone
    assert room.client.post("/room/begin", json={}).status_code == 200


def test_a_full_disk_ends_the_film_with_one_sentence_and_what_it_has_stays(tmp_path: Path):
    room = Room(tmp_path)
    name, key = room.begin()
    room.chunk(name, 0, WEBM, key)
    room.free = 1e8
    for language, words in (("en", "Less than 1 GB"), ("de", "Weniger als 1 GB")):
        answer = room.client.post(
            f"/room/{name}/1?lang={language}", content=b"x", headers={"content-type": "video/webm", "x-room-key": key}
        )
        assert answer.status_code in (507, 409) and words in answer.json()["why"]
    assert (tmp_path / "room_1.webm").read_bytes() == WEBM
    assert room_lamp(room.store.shown, ENGLISH, 0.0) == ("bad", "room (browser): recording broke off")
    assert "Less than 1 GB" in room.client.post("/room/begin", json={}).json()["why"]
    room.free = 1e12
    assert room.begin()[0] == "room_2"


def test_without_a_folder_or_a_recorder_the_switch_says_so(tmp_path: Path):
    for folder in (None, tmp_path / "gone"):
        assert "where the session's recording lies" in Room(folder).client.get("/room/possible").json()["why"]
    room = Room(tmp_path)
    room.records = False
    for answer in (room.client.get("/room/possible"), room.client.post("/room/begin", json={})):
        assert answer.status_code == 409 and "No recorder" in answer.json()["why"]
    assert list(tmp_path.iterdir()) == []


def test_each_test_signal_is_marked_once_at_its_moment_and_written_beside_the_film(tmp_path: Path):
    room = Room(tmp_path)
    name, key = room.begin()
    for facts in (FACTS, FACTS, {**FACTS, "signals": [*FACTS["signals"], [2, 3.0, 0.0]], "ended": True}):
        assert room.client.post(f"/room/{name}", json={**facts, "key": key}).status_code == 200
    assert room.notes == [
        WriteNote("room_1 1", SIGNAL_MARKER, 999.75),
        WriteNote("room_1 2", SIGNAL_MARKER, 1001.0),
    ]
    kept = read_room_recording(tmp_path / "room_1.json")
    assert kept == room_recording({**FACTS, "signals": [[1, 1.75, 0.03], [2, 3.0, 0.0]], "ended": True})
    start = json.loads((tmp_path / "room_1.json").read_text())["start"]
    assert start == {"session_time_s": 1000.0, "uncertainty_s": 0.001}
    assert room.store.shown == ()
    assert room.chunk(name, 0, WEBM, key).status_code == 404  # it has ended
    far = room.client.post(f"/room/{room.begin()[0]}", json={**FACTS, "key": "wrong"})
    assert far.status_code == 404 and len(room.notes) == 2


anything = st.recursive(
    st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=5)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(sorted(FACTS)), inner)),
    max_leaves=12,
)


@given(anything, st.sampled_from(sorted(FACTS)))
def test_whatever_describes_a_film_is_taken_or_refused_in_a_sentence(raw: object, name: str):
    for read in (raw, {**FACTS, name: raw}):
        try:
            recording = room_recording(read)
        except RoomError as refusal:
            assert "expected" in str(refusal) or "is no list" in str(refusal) or "numbered" in str(refusal) or (
                "no list of three" in str(refusal)
            )  # fmt: skip
        else:
            assert recording.clock


def test_the_bar_says_that_the_room_is_recorded_and_when_nothing_comes():
    film = (ShownFilm("room_1", 10.0),)
    assert room_lamp(film, ENGLISH, 11.0) == ("bad live", "ROOM IS RECORDED (sound, picture; browser)")
    assert room_lamp(film, PageTexts("de"), 30.0) == ("bad", "Raum (Browser): seit 20 s kam nichts")
    assert room_lamp(film, ENGLISH, 80.0) == ("bad", "room (browser): recording broke off")
    assert room_lamp((), ENGLISH, 30.0) is None


def test_a_film_by_a_device_is_shown_while_it_grows_and_when_it_broke_off():
    sound = DeviceReport("room_1", sound=True, picture=False)
    growing = console_state.on_filmed(ConsoleState(), sound, 10.0, 100.0)
    assert room_lamp(growing.filmed, ENGLISH, 11.0) == ("bad live", "ROOM IS RECORDED (sound; device)")
    assert room_lamp(growing.filmed, ENGLISH, 20.0) == ("bad", "room (device): nothing came for 10 s")
    assert room_sentence(growing.filmed, ENGLISH, 20.0) == ("Sound of this room is being recorded, no picture.", True)
    ended = console_state.on_filmed(growing, replace(sound, ended=True), 12.0, 102.0)
    assert (ended.filmed, ended.log) == ((), ())
    lost = replace(sound, lost="hw:0 was taken away")
    broken = console_state.on_filmed(console_state.on_filmed(growing, lost, 12.0, 102.0), lost, 13.0, 103.0)
    assert room_lamp(broken.filmed, ENGLISH, 13.0) == ("bad", "room (device): recording broke off")
    said, live = room_sentence(broken.filmed, ENGLISH, 13.0)
    assert said.startswith("The recording of this room has broken off") and not live
    assert [line.text for line in broken.log] == ["room_1: hw:0 was taken away"]
    again = console_state.on_filmed(broken, DeviceReport("room_2", True, True), 14.0, 104.0)
    assert room_lamp(again.filmed, ENGLISH, 14.0) == ("bad live", "ROOM IS RECORDED (sound, picture; device)")


def test_a_session_that_begins_does_not_hide_that_the_room_is_filmed():
    growing = console_state.on_filmed(ConsoleState(), DeviceReport("room_1", True, True), 10.0, 100.0)
    assert console_state.on_session(growing, SessionState("p02", Phase.OBSERVE_SOURCE), 101.0).filmed


def test_what_a_page_has_is_what_the_pages_show(tmp_path: Path):
    room = Room(tmp_path)
    assert room.client.post("/room/begin", json={"sound": True, "picture": False}).status_code == 200
    assert room_lamp(room.store.shown, ENGLISH, 0.0) == ("bad live", "ROOM IS RECORDED (sound; browser)")


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_switch_is_off_and_has_every_word_its_script_says(language: str):
    markup = room_panel(PageTexts(language))
    assert 'role="switch" aria-checked="false"' in markup
    script = (Path(room_panel.__code__.co_filename).parents[1] / "static" / "room.js").read_text()
    assert set(re.findall(r'words\("(room_\w+)"', script)) == set(SAID)


@pytest.mark.parametrize(
    ("path", "eyes"), [("/", "(self)"), ("/observe", "()"), ("/steps", "()"), ("/room/clock", "()")]
)
def test_only_the_operators_page_may_ask_for_camera_and_microphone(path: str, eyes: str):
    app = FastAPI()
    app.get(path)(lambda: {})
    app.add_middleware(SecurityHeaders)
    policy = TestClient(app).get(path).headers["permissions-policy"]
    assert policy == f"camera={eyes}, microphone={eyes}, geolocation=()"
