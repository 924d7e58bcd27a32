"""The study's tools: forms on the page, markers, checklist, countdown, the bar, and what survives a restart."""

from __future__ import annotations

import dataclasses
import html
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console.actions import KEYS
from mbd_console.parts.pressed_keys import action_of_key
from mbd_console.requests import RequestRefusedError, read_request
from mbd_console.restart.kept_console import KeptConsole
from mbd_console.state import ConsoleState
from mbd_console.status.bar import announced, status_bar
from mbd_console.status.recorder import recorder_state
from mbd_console.study import board as study_board
from mbd_console.study.board import StudyBoard
from mbd_console.study.form_html import form_html
from mbd_console.study.form_plan import form_plan
from mbd_console.study.markers import MARKERS
from mbd_console.study.panel import countdown_words, study_panel
from mbd_console.study.requests import read_form_sent, read_study
from mbd_console.words.texts import LANGUAGES, PageTexts
from mbd_model.errors import MbdError
from mbd_model.forms.form import FormError
from mbd_model.forms.reading import read_form, shipped_forms
from mbd_model.objects import Role
from mbd_model.session import Phase, SessionState

ENGLISH = PageTexts("en")
PLAN = form_plan(["consent@observe_source", "nasa_tlx@done", "closing@done"])
STATE = ConsoleState(session=SessionState("p01", Phase.OBSERVE_SOURCE))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", shipped_forms())
def test_each_item_of_a_form_is_a_named_field_with_its_words(name: str, language: str):
    form = read_form(name)
    markup = form_html(form, PageTexts(language))
    assert set(re.findall(r' name="([^"]+)"', markup)) == {item.name for item in form.items}
    assert all(item.text.in_language(language) in html.unescape(markup) for item in form.items)
    # Each field has a label around it, or one that names it.
    fields = len(re.findall(r"<(input|textarea) ", markup))
    assert len(re.findall(r"<label", markup)) == fields


def test_forms_come_with_their_phase_one_after_the_other_and_once():
    board = study_board.due(StudyBoard(), PLAN, Phase.DONE, 5.0)
    assert (board.shown, board.since) == ("nasa_tlx", 5.0)
    assert study_board.due(board, PLAN, Phase.OBSERVE_SOURCE, 6.0).shown == "nasa_tlx"
    back = study_board.came_back(board, "nasa_tlx", declined=False)
    assert (back.shown, back.sent) == ("", ("nasa_tlx",))
    assert study_board.due(back, PLAN, Phase.DONE, 7.0).shown == "closing"
    assert study_board.came_back(back, "nasa_tlx", declined=True).declined == ("nasa_tlx",)


@pytest.mark.parametrize("entry", ["nasa", "sus@lunch", "./none.yaml"])
def test_a_form_or_phase_there_is_not_is_refused_with_those_there_are(entry: str):
    with pytest.raises(FormError, match=r"there are|shipped are"):
        form_plan([entry])
    with pytest.raises(FormError, match="twice"):
        form_plan(["sus", "sus@done"])


def test_an_answer_is_taken_for_the_form_that_is_shown_and_for_no_other():
    shown = dataclasses.replace(STATE, study=study_board.show(StudyBoard(), "closing", 3.0))
    sent = read_form_sent({"form": "closing", "language": "de", "answers": {"remarks": "gut"}}, shown, PLAN)
    assert (sent.filled.language, sent.opened) == ("de", 3.0)
    assert {a.item: a.value for a in sent.filled.answers} == {"guessed_rule": "", "remarks": "gut"}
    for raw in ({"form": "sus", "answers": {}}, {"form": "closing"}, None, {"form": "closing", "answers": 3}):
        with pytest.raises(RequestRefusedError):
            read_form_sent(raw, shown, PLAN)
    with pytest.raises(RequestRefusedError):
        read_form_sent({"form": "closing", "answers": {}}, STATE, PLAN)


raws = st.one_of(
    st.none(),
    st.text(),
    st.dictionaries(
        st.sampled_from(["do", "name", "minutes"]),
        st.one_of(
            st.sampled_from(["marker", "tick", "form", "countdown", "phrase"]), st.floats(), st.text(), st.none()
        ),
    ),
)


@given(raws)
def test_whatever_a_page_sends_changes_the_board_or_is_refused(raw: object):
    try:
        change = read_study(raw, STATE, PLAN, ENGLISH, 1.0)
    except MbdError as refusal:
        assert "reload the page" in str(refusal) or "countdown" in str(refusal)
        return
    assert change.board is not None or change.note is not None


@pytest.mark.parametrize("minutes", [10**400, True, "x", [], math.nan, -1, 0])
def test_a_countdown_of_no_number_of_minutes_is_refused_in_a_sentence(minutes: object):
    with pytest.raises(RequestRefusedError, match="a countdown takes more than 0"):
        read_study({"do": "countdown", "minutes": minutes}, STATE, PLAN, ENGLISH, 10.0)


def test_a_tick_a_marker_and_a_countdown_are_noted_in_the_bag():
    ticked = read_study({"do": "tick", "name": "OBSERVE_SOURCE 1"}, STATE, PLAN, ENGLISH, 1.0)
    assert ticked.board is not None and "OBSERVE_SOURCE 1" in ticked.board.ticked
    assert ticked.note is not None and (ticked.note.text, ticked.note.marker) == ("✓ consent is signed", "checklist")
    marked = read_study({"do": "marker", "name": "quote"}, STATE, PLAN, PageTexts("de"), 1.0)
    assert marked.note is not None and (marked.note.text, marked.note.marker) == ("Zitat", "quote")
    begun = read_study({"do": "countdown", "minutes": 2}, STATE, PLAN, ENGLISH, 10.0)
    assert begun.board is not None and begun.board.ends == 130.0
    left = dataclasses.replace(STATE, study=begun.board)
    assert [countdown_words(left, ENGLISH, at) for at in (10.0, 100.5, 130.0)] == [
        "2:00 left", "0:30 left", "time is over",
    ]  # fmt: skip


def test_markers_take_no_key_that_means_something_else_and_other_keys_mean_nothing():
    assert not set(MARKERS) & (set(KEYS) | {"v", "?", "t"})
    assert action_of_key({"action": "key", "key": "h"}) == {"do": "marker", "name": "hesitates"}
    assert action_of_key({"action": "key", "key": "z"}) is None
    assert "Consent" in study_panel(STATE, PLAN, ENGLISH)


@pytest.mark.parametrize(
    ("age", "values", "words"),
    [
        (1.0, {"recording": "yes", "missed": "0", "disk left [MB]": "42000"}, ["recording", "disk: 42.0 GB left"]),
        (9.0, {"recording": "yes", "missed": "3"}, ["recorder silent for 9 s", "3 messages not recorded", "disk: ?"]),
        (1.0, {"recording": "no, the session is over", "missed": "0"}, ["recording ended"]),
    ],
)
def test_the_bar_says_what_is_recorded_and_how_old_that_is(age: float, values: dict[str, str], words: list[str]):
    state = dataclasses.replace(STATE, recorder=recorder_state(values, "", 100.0))
    bar = status_bar(state, ENGLISH, 100.0 + age, 100.0)
    assert ET.fromstring(f"<all>{bar}</all>") is not None
    assert all(word in bar for word in [*words, "connected"])
    assert ("picture 9 s old" in bar) == (age == 9.0)
    running = dataclasses.replace(state, session=dataclasses.replace(STATE.session, recording=True))
    assert "DEMONSTRATION IS RECORDED" in status_bar(running, ENGLISH, 101.0, None)
    assert "NOT RECORDED" in status_bar(STATE, ENGLISH, 1.0, None)


def test_the_bar_says_that_a_form_is_open_so_that_nobody_goes_on_meanwhile():
    bar = status_bar(STATE, ENGLISH, 1.0, 1.0, form="Consent <i>")
    assert "form being filled in: Consent &lt;i&gt;" in bar
    assert "Consent" in announced(STATE, ENGLISH, 1.0, form="Consent")
    assert "being filled in" not in status_bar(STATE, ENGLISH, 1.0, 1.0) + announced(STATE, ENGLISH, 1.0)


def test_a_picture_is_old_only_by_a_clock_that_goes_on():
    """A simulation that waits for the operator sends no pictures, and its clock stands: no camera has failed."""
    assert "simulated time stands, 9 s" in status_bar(STATE, ENGLISH, 10.0, 1.0, session_age=0.1)
    for age in (9.0, None):
        assert "picture 9 s old" in status_bar(STATE, ENGLISH, 10.0, 1.0, session_age=age)


@pytest.mark.parametrize("phase", [Phase.DONE, Phase.ABORTED])
def test_once_the_session_is_over_an_ended_recording_is_no_warning(phase: Phase):
    ended = recorder_state({"recording": "no", "missed": "0"}, "", 1.0)
    over = dataclasses.replace(STATE, session=SessionState("p01", phase), recorder=ended)
    lamp = '<span class="lamp {}">recording ended'
    assert lamp.format("good") in status_bar(over, ENGLISH, 1.0, 1.0)
    assert lamp.format("warn") in status_bar(dataclasses.replace(STATE, recorder=ended), ENGLISH, 1.0, 1.0)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", shipped_forms())
def test_a_form_says_in_its_own_language_what_is_wrong_and_how_long_it_is(name: str, language: str):
    """The browser's own bubbles speak the browser's language, and name no button."""
    texts = PageTexts(language)
    markup = html.unescape(form_html(read_form(name), texts))
    assert " novalidate" in markup
    for kind in ("lacks", "open", "number"):
        words = texts(f"form_{kind}", send=texts("form_send"))
        assert f'data-{kind}="{words}"' in markup
        assert texts("form_send") in words
    count = len(read_form(name).items)
    assert (texts("form_length", count=count, send=texts("form_send")) in markup) == (count >= 6)


def test_a_paused_session_says_so_as_the_reason():
    paused = ConsoleState(session=SessionState("p", Phase.DEMONSTRATE, paused=True, detail="no tool pose"))
    with pytest.raises(RequestRefusedError, match="paused"):
        read_request({"action": "start"}, paused)


def test_clock_board_and_photographs_outlive_a_console_and_are_of_their_session_only(tmp_path: Path):
    kept = KeptConsole(tmp_path)
    board = StudyBoard("sus", 4.0, ("consent",), ("closing",), frozenset({"DONE 1"}), 99.5)
    state = dataclasses.replace(STATE, began=10.0, phase_began=20.0, study=board)
    kept.keep(state)
    again = dataclasses.replace(STATE, began=70.0, phase_began=70.0)
    assert kept.restored(again) == (10.0, 20.0, board)
    assert kept.restored(dataclasses.replace(again, session=SessionState("p02", Phase.OBSERVE_SOURCE))) is None
    later = dataclasses.replace(again, session=SessionState("p01", Phase.ASSIST))
    assert kept.restored(later) == (10.0, 70.0, board)
    picture = np.full((48, 64, 3), (200, 30, 30), np.uint8)
    kept.keep_picture(Role.SOURCE, 12.25, picture)
    found = kept.picture(Role.SOURCE, 12.25)
    assert found is not None and np.abs(found.astype(int) - picture).max() < 6
    assert kept.picture(Role.SOURCE, 13.0) is None
    (tmp_path / "console.json").write_text("{")
    assert kept.restored(again) is None
