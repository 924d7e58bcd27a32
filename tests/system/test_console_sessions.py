"""Complete sessions, led by an operator who has the console's page and nothing else."""

from __future__ import annotations

import re
import subprocess
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from console_browser import CHROMIUM, DRIVER, Browser, question_about
from console_hands import Hand
from console_session import ConsoleSession, console_session
from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.live_session import install_prefixes
from mbd_bringup.ros.next_offer import NextOffer
from mbd_model.session import Phase
from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import read_plan

pytestmark = [
    pytest.mark.timeout(900),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]


# Thresholds that no estimate passes early, so that there is much to answer.
BY_KEYS, BY_FINGER, BY_MOUSE = ("stacking", 2, 0.9), ("sorting", 3, 0.6), ("lunch_packing", 1, 1.0)


def options_of(case: tuple[str, int, float], folder: Path) -> SessionOptions:
    task, seed, threshold = case
    return SessionOptions("console", folder / "console", task=task, seed=seed, threshold=threshold, speed=0.0)


def lead_to_the_end(session: ConsoleSession, *browsers: Browser) -> None:
    """From the first question to the last, and until every page shows the end."""
    session.lead(*browsers, until=lambda: session.phase is Phase.ASSIST)
    for browser in browsers:
        browser.wait(lambda b=browser: len(b.all(".step")) >= 6, "the page lacks steps")
        browser.wait(lambda b=browser: len(b.all(".mapping image")) == 2, "the mapping lacks one of its pictures")
    session.lead(*browsers, until=lambda: session.phase is Phase.DONE)
    for browser in browsers:
        browser.wait(lambda b=browser: b.phase() is Phase.DONE, "the page does not see the end")
        browser.wait(lambda b=browser: b.all(".camera.seen"), "no live picture")
        browser.wait(lambda b=browser: len(b.all(".confidence circle")) >= 1, "the page lacks estimates")


def test_by_keyboard_alone_and_through_a_restart_of_the_console_at_a_question(tmp_path: Path):
    options = options_of(BY_KEYS, tmp_path)
    with console_session(options) as session, closing(Browser(session.address, tmp_path / "profile")) as browser:
        session.hand = Hand.KEYS
        browser.wait(browser.phase, "the page does not state where the session is")
        session.lead(browser, until=lambda: session.phase is Phase.ASSIST and session.asked_step >= 0)
        restart_at_a_question(session, browser)
        lead_to_the_end(session, browser)
    assert_right(options)


def restart_at_a_question(session: ConsoleSession, browser: Browser) -> None:
    """Kill the console as ``kill -9`` would, and start it again: the page is as it was, the question still asked."""

    def seconds_before_this_phase() -> int:
        """How long the session went on before its phase by the page's clock, the same all that phase; -1: no clock."""
        shown = [int(m) * 60 + int(s) for m, s in re.findall(r"(\d+):(\d\d)", browser.text(".clock"))]
        return shown[0] - shown[1] if len(shown) == 2 else -1

    def photographs() -> int:
        """How many pictures of the scenes the page gets of its console."""
        script = """return Promise.all([...document.querySelectorAll('.mapping image')].map(i =>
            fetch(i.getAttribute('href')).then(r => r.ok, () => false))).then(all => all.filter(Boolean).length)"""
        return int(browser.driver.execute_script(script))

    question = question_about(session.asked_step)
    browser.wait(lambda: browser.all(question), "the question is not on the page")
    browser.wait(lambda: photographs() == 2, "the page lacks the photographs before the restart")
    browser.wait(lambda: seconds_before_this_phase() >= 2, "no clock that could be lost")
    before = seconds_before_this_phase()
    browser.driver.execute_script("window.beforeTheRestart = true")
    session.processes.restart("console")
    reloaded = "return !window.beforeTheRestart && document.querySelector('#veil')?.hidden === true"
    browser.wait(lambda: browser.driver.execute_script(reloaded), "the page does not come back", timeout=180.0)
    browser.wait(lambda: browser.all(question), "the question is no more on the page")
    browser.wait(lambda: photographs() == 2, "the photographs are lost")
    browser.wait(lambda: abs(seconds_before_this_phase() - before) <= 1, "the clock is lost")


def test_with_a_finger_on_a_tablet_alone(tmp_path: Path):
    options = options_of(BY_FINGER, tmp_path)
    with console_session(options) as session, closing(Browser(session.address, tmp_path / "profile")) as browser:
        session.hand = Hand.FINGER
        browser.be_tablet()
        browser.wait(browser.phase, "the page does not state where the session is")
        lead_to_the_end(session, browser)
    assert_right(options)


def test_by_clicks_on_two_consoles_in_turn_and_the_plan_s_next_session_is_begun_from_there(tmp_path: Path):
    plan = tmp_path / "plan.yaml"
    plan.write_text("study: s\nseed: 1\nconditions: [mbd]\ntasks: [lunch_packing]\nparticipants: [p1, p2]\n")
    first, second = planned_sessions(read_plan(plan))
    options = replace(options_of(BY_MOUSE, tmp_path), plan=(f"session={first.session}",))
    with console_session(options) as session:
        one, other = (Browser(session.address, tmp_path / name) for name in ("one", "other"))
        with closing(one), closing(other):
            session.hand = Hand.MOUSE
            for browser in (one, other):
                browser.wait(browser.phase, "the page does not state where the session is")
            lead_to_the_end(session, one, other)
            offer = NextOffer(session.wizard)
            offer.offer(second)
            other.says(".next-session", second.participant)
            other.press("[data-study=begin]")
            other.wait(lambda: offer.begun, "the next session was not begun")
    assert_right(options)


def assert_right(options: SessionOptions) -> None:
    """The last estimate of a session's bag is right."""
    table = install_prefixes(["mbd_study"])["mbd_study"] / "lib" / "mbd_study" / "table"
    shown = subprocess.run([str(table), str(options.bag)], capture_output=True, text=True, check=False).stdout
    assert re.findall(r"\b(right|wrong)\b", shown)[-1] == "right", shown
