"""The operator's page begins the session that is offered, when this one is over, and no other."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mbd_console.requests import BeginSession, RequestRefusedError
from mbd_console.state import ConsoleState, on_offered, on_session
from mbd_console.study.next_panel import next_panel
from mbd_console.study.offered import OfferedSession
from mbd_console.study.requests import read_study
from mbd_console.words.texts import LANGUAGES, PageTexts
from mbd_model.session import Phase, SessionState

NEXT = OfferedSession("p02_mbd_sorting", "p02", "sorting", "mbd")
OVER = (Phase.DONE, Phase.ABORTED)


def state(phase: Phase, offered: OfferedSession | None = NEXT) -> ConsoleState:
    shown = replace(ConsoleState(), session=SessionState("p01_mbd_sorting", phase))
    return shown if offered is None else on_offered(shown, offered)


def begins(shown: ConsoleState, name: object) -> BeginSession | None:
    return read_study({"do": "begin", "name": name}, shown, (), PageTexts(), 0.0).begins


@pytest.mark.parametrize("phase", Phase)
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_button_is_there_once_the_session_is_over(phase: Phase, language: str):
    shown = next_panel(state(phase), PageTexts(language))
    assert ('data-name="p02_mbd_sorting"' in shown) == (phase in OVER)
    assert ("p02" in shown) == (phase in OVER)
    assert next_panel(state(phase, None), PageTexts(language)) == ""


@pytest.mark.parametrize("phase", Phase)
def test_a_press_begins_what_is_offered_and_is_refused_while_the_session_runs(phase: Phase):
    if phase in OVER:
        assert begins(state(phase), NEXT.session) == BeginSession(NEXT.session)
        return
    with pytest.raises(RequestRefusedError, match="still runs"):
        begins(state(phase), NEXT.session)


@pytest.mark.parametrize("name", ["p01_mbd_sorting", "", None, 7, ["p02_mbd_sorting"]])
def test_a_press_for_another_session_than_the_one_offered_is_refused(name: object):
    with pytest.raises(RequestRefusedError, match="look at what the page offers now"):
        begins(state(Phase.DONE), name)


def test_why_nothing_is_next_is_shown_in_place_of_the_button_and_begins_nothing():
    for offered in (replace(NEXT, problem="the <plan> is gone"), replace(NEXT, session="")):
        shown = state(Phase.DONE, offered)
        said = next_panel(shown, PageTexts())
        assert "<button" not in said
        assert "<plan>" not in said
        with pytest.raises(RequestRefusedError):
            begins(shown, offered.session)


def test_the_offer_is_forgotten_with_the_session_it_was_made_in():
    after = on_session(state(Phase.DONE), SessionState("p02_mbd_sorting", Phase.OBSERVE_SOURCE), 1.0)
    assert after.offered is None
