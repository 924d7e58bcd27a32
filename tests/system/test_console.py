"""The wizard's console in a real browser: what its pages show, what a press sends, and what they must never do."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path

import httpx
import pytest
from console_browser import CHROMIUM, DRIVER
from console_session import free_port
from console_stage import Open, Stage, is_asked, page_of
from mbd_bringup.ros.live_session import install_prefixes
from mbd_model.assists import Assist
from mbd_model.session import Awaited, Phase, PromptKind
from mbd_msgs import msg as m
from selenium.webdriver.common.keys import Keys

pytestmark = [
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]


def test_objects_are_handed_pointed_at_and_meant_by_click_and_by_number(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    is_asked(browser)
    browser.click_object("t3")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.object_id) == ("handed", "t3")
    stage.others.ask(1, (Assist("s1", "t3", 0),))
    is_asked(browser, 1)
    browser.key("2")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.object_id) == ("pointed", "t2")
    browser.key("m")
    browser.wait(lambda: browser.all(".prompt.meant"), "no step was chosen to correct")
    browser.click_object("t1")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.step_index, msg.object_id) == ("overwrite", 0, "t1")


IS_THAT_SO = "You gave me t3 for s1: is that so?"


def test_is_that_so_is_shown_on_both_pages_and_answered_by_button_and_by_key(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    observer = browse(f"{stage.address}/observe")
    for number, (press, answer) in enumerate(
        (
            (lambda: browser.click("yes"), m.WizardAnswer.YES),
            (lambda: browser.key("w"), m.WizardAnswer.NO),
            (lambda: browser.key("y"), m.WizardAnswer.YES),
        ),
        start=1,
    ):
        # A yes to the question before is refused: each is another one, and is pressed when that one is on the page.
        question = f"{IS_THAT_SO} ({number})"
        stage.others.ask_whether(PromptKind.CONFIRM_ASSIST, Awaited.CONFIRMATION, question, "t3")
        browser.wait(lambda q=question: any(q in e.text for e in browser.all(".prompt.question")), "not asked")
        observer.wait(lambda: "Did you mean that?" in observer.text(".prompt.question"), "not asked in lay words")
        browser.says(".doubt", "Doubted: s1 is t3", "the doubt is not shown")
        browser.wait(lambda: browser.all("[data-action=yes]:not([disabled])"), "yes cannot be pressed")
        assert not observer.all("[data-action]:not([data-action=stop_robot])")
        press()
        topic, msg = stage.others.next_sent()
        assert (topic, msg.answer) == ("answer", answer)


def test_one_of_two_is_chosen_by_click_and_neither_by_no(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    question = "Which is the one for s1: t2 or t3? (step 1)"
    stage.others.ask_whether(PromptKind.WHICH_OF_TWO, Awaited.ONE_OF_TWO, question, "t2", "t3")
    browser.wait(lambda: any(question in e.text for e in browser.all(".prompt.question")), "not asked")
    browser.wait(lambda: browser.all("[data-action=no]:not([disabled])"), "no cannot be pressed")
    assert browser.all("[data-action=yes][disabled]")
    browser.click_object("t2")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.object_id) == ("handed", "t2")
    browser.click("no")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.answer) == ("answer", m.WizardAnswer.NO)


def test_a_place_on_the_table_is_pointed_at_where_it_was_clicked(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(1)
    is_asked(browser, 1)
    browser.wait(lambda: browser.all("[data-place]"), "the table cannot be pointed at")
    # The middle of the picture; the default camera looks straight down from 1.2 m above (0.6, 0).
    browser.press(".stage")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.object_id) == ("pointed", "")
    assert (msg.place.x, msg.place.y, msg.place.z) == pytest.approx((0.6, 0.0, 0.0), abs=0.005)


def test_what_cannot_be_taken_back_is_pressed_twice(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    browser.wait(lambda: browser.all("[data-action=abort]:not([disabled])"), "abort is not offered")
    browser.key("X")
    browser.wait(lambda: "Press again" in browser.text("[data-action=abort]"), "abort was not armed")
    browser.key(Keys.ESCAPE)
    browser.wait(lambda: "Press again" not in browser.text("[data-action=abort]"), "escape did not disarm")
    browser.click("abort")
    browser.click("pause")
    browser.click("abort")
    browser.key("X")
    sent = [stage.others.next_sent()[1].command for _ in range(2)]
    assert sent == [m.WizardCommand.PAUSE, m.WizardCommand.ABORT]


def test_two_consoles_stay_in_step(stage: Stage, browse: Open):
    first, second = page_of(stage, browse), page_of(stage, browse)
    stage.others.ask(0, (Assist("s2", "t2", 1),))
    for browser in (first, second):
        browser.wait(lambda b=browser: b.phase() is Phase.ASSIST, "not in the phase")
        is_asked(browser)
    first.note("seen by both")
    second.wait(lambda: "seen by both" in second.text(".log"), "the note did not reach the other console")
    assert stage.others.next_sent()[0] == "note"
    stage.others.reply("/wizard/handed", accepted=False, reason="unknown object 't9'")
    for browser in (first, second):
        browser.wait(lambda b=browser: "unknown object 't9'" in b.text(".reply.refused"), "no refusal")
    for panel in (".banner", ".steps", ".log", ".mapping", ".phases", ".overlay"):
        first.wait(lambda p=panel: first.text(p) == second.text(p), f"the two pages differ in {panel}")


def test_the_participant_sees_the_belief_and_can_press_nothing_but_the_stop(stage: Stage, browse: Open):
    observer, operator = page_of(stage, browse, "/observe"), page_of(stage, browse)
    stage.others.ask(0)
    observer.wait(lambda: "What shall I take now? You took" in observer.text(".prompt"), "the question is not shown")
    pressed = observer.all("button, [data-action], .choosing")
    assert [e.get_attribute("data-action") for e in pressed] == ["stop_robot"]
    # What is there concerns the page itself: whether it speaks, and its language.
    assert [e.get_attribute("id") for e in observer.all("input")] == ["speak"]
    assert all("/observe" in (e.get_attribute("href") or "") for e in observer.all("a"))
    for key in "nocX1u":
        observer.key(key)
    operator.wait(lambda: operator.all("[data-action=open]"), "no console")
    operator.key("o")
    assert stage.others.next_sent()[0] == "gripper"
    with pytest.raises(queue.Empty):
        stage.others.next_sent(timeout=0.5)


def test_text_in_a_note_is_shown_as_text(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    text = "<img src=x onerror=\"document.title='owned'\"><b>bold</b>"
    browser.wait(lambda: browser.all(".note-input"), "no field for notes")
    browser.note(text)
    topic, msg = stage.others.next_sent()
    assert (topic, msg.text) == ("note", text)
    browser.wait(lambda: text in browser.text(".log .note"), "the note is not in the log")
    assert browser.all(".log img, .log .note b b, .log span b") == []
    assert browser.driver.title != "owned"


def test_a_page_comes_back_by_itself_when_its_console_does(fresh_stage: Stage, browse: Open):
    browser = page_of(fresh_stage, browse)
    fresh_stage.others.be_in(Phase.DEMONSTRATE)
    browser.wait(lambda: browser.phase() is Phase.DEMONSTRATE, "no phase")
    fresh_stage.kill_console()
    fresh_stage.others.be_in(Phase.TUCK_AND_CLEAR)
    browser.wait(lambda: browser.phase() is Phase.TUCK_AND_CLEAR, "the page did not come back", timeout=120.0)

    def reaches_the_others() -> bool:
        browser.key("c")
        try:
            return fresh_stage.others.next_sent(timeout=1.0)[0] == "gripper"
        except queue.Empty:
            return False

    # The others may discover the new console later than it discovers them.
    browser.wait(reaches_the_others, "what is pressed reaches nobody")


def test_what_a_forged_page_sends_is_refused_on_the_page_and_goes_nowhere(fresh_stage: Stage, browse: Open):
    browser = page_of(fresh_stage, browse)
    fresh_stage.others.ask(0)
    browser.wait(lambda: browser.all(".choosing"), "nothing to choose")
    forged = (
        "{action: 'object', object_id: 't99', question: 1}",
        "{action: 'object', object_id: 't1', question: -1}",
        "{action: 'overwrite', step_index: 0, object_id: 't1'}",
        "{action: {}}",
        "'nonsense'",
        "{action: 'note', text: 'x'.repeat(5000)}",
        "null",
    )
    for args in forged:
        browser.driver.execute_script(f"emitEvent('console', {args})")
    browser.wait(lambda: browser.text(".log").count("console") >= len(forged), browser.text(".log"))
    browser.key("c")
    assert fresh_stage.others.next_sent()[0] == "gripper"


def test_nothing_is_fetched_from_elsewhere(stage: Stage, browse: Open):
    for path in ("", "/observe"):
        browser = page_of(stage, browse, path)
        fetched = browser.driver.execute_script("return performance.getEntriesByType('resource').map(e => e.name)")
        assert len(fetched) > 5
        assert [f for f in fetched if not f.startswith((stage.address, "blob:", "data:"))] == []


@pytest.mark.parametrize("size", [(1280, 800), (1024, 768), (768, 1024)])
def test_it_fits_laptop_and_tablet(stage: Stage, browse: Open, size: tuple[int, int]):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    is_asked(browser)
    browser.resize(*size)
    box = "return (e => [e.scrollWidth, e.scrollHeight])(document.scrollingElement)"
    browser.wait(lambda: browser.driver.execute_script(box)[0] <= size[0], f"wider than {size}")
    if size[0] > size[1]:
        assert browser.driver.execute_script(box)[1] <= size[1]
    # Read at once: a button that is drawn again meanwhile has no place.
    places = """return [...document.querySelectorAll('[data-action]')].map(e => [e.textContent,
        e.getBoundingClientRect().toJSON()])"""
    assert browser.driver.execute_script("return document.querySelector('.clock').checkVisibility()")
    for text, place in browser.driver.execute_script(places):
        assert place["left"] >= 0 and place["right"] <= size[0], text
        assert place["height"] >= 36, text
        assert place["bottom"] <= size[1], text


def test_the_network_gets_in_with_the_token_only(tmp_path: Path, ros_domain: int):
    program = install_prefixes(["mbd_console"])["mbd_console"] / "lib" / "mbd_console" / "console"
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    port = free_port()
    words = ["--ros-args", "-p", f"port:={port}"]
    open_to_all = [str(program), *words, "-p", "host:=0.0.0.0"]
    refused = subprocess.run(open_to_all, env=environment, capture_output=True, text=True, check=False, timeout=60)
    assert refused.returncode != 0
    assert "--token" in refused.stderr
    process = subprocess.Popen([str(program), "--token", "letmein123", *words], env=environment)
    try:
        address = f"http://127.0.0.1:{port}/"
        assert [_status(address), _status(f"{address}?token=letmein123")] == [401, 401]
        assert _sign_in(address, "letmein124").status_code == 401
        page = _sign_in(address, "letmein123")
        assert page.status_code == 200
        assert "frame-ancestors 'none'" in page.headers["content-security-policy"]
        assert "<script nonce=" in page.text
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0, "Ctrl-C does not end it quietly"
    finally:
        process.kill()
        process.wait()


def _sign_in(address: str, token: str) -> httpx.Response:
    """What comes of the form, redirections followed."""
    with httpx.Client(follow_redirects=True) as client:
        return client.post(f"{address}sign_in", data={"token": token})


def _status(address: str, patience: float = 90.0) -> int:
    end = time.monotonic() + patience
    while True:
        try:
            return int(urllib.request.urlopen(address, timeout=10).status)
        except urllib.error.HTTPError as error:
            return error.code
        except urllib.error.URLError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)
