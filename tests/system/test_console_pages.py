"""The operator's and the participant's page for everybody: by keyboard, by ear, in two languages, when things fail."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from accessibility import needs_axe, prefer, violations
from console_browser import CHROMIUM, DRIVER, Browser
from console_stage import Open, Stage, console_stage, is_asked, page_of
from mbd_model.assists import Assist
from mbd_model.session import Phase
from mbd_msgs import msg as m
from selenium.webdriver.common.keys import Keys

FORMS = ["consent", "demographics", "nasa_tlx", "sus", "godspeed", "closing"]
pytestmark = [
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]


@pytest.fixture(scope="module")
def one_stage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    """A console with a study's forms, and a folder for what survives it."""
    folder = tmp_path_factory.mktemp("pages")
    with console_stage(folder, {"forms": FORMS, "state_dir": str(folder / "state")}) as running:
        yield running


def focused(browser: Browser) -> str:
    """What has the focus, as the names of its data, or its tag."""
    script = """const e = document.activeElement; const d = e.dataset;
        return d.action ?? d.object ?? d.toggle ?? d.study ?? e.tagName"""
    return str(browser.driver.execute_script(script))


def shown(browser: Browser, selector: str) -> bool:
    return bool(browser.driver.execute_script("return !document.querySelector(arguments[0])?.hidden", selector))


@needs_axe
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_wrong_on_any_page_in_either_scheme(stage: Stage, browse: Open, scheme: str):
    browser = page_of(stage, browse)
    prefer(browser, scheme)
    stage.others.ask(0, (Assist("s1", "t3", 0),))
    is_asked(browser)
    assert violations(browser) == []
    browser.key("v")
    browser.wait(lambda: shown(browser, ".study-tools"), "no study tools")
    assert violations(browser) == []
    observer = browse(f"{stage.address}/observe?lang=de")
    prefer(observer, scheme)
    observer.wait(lambda: observer.all(".prompt.question"), "the participant is asked nothing")
    assert violations(observer) == []
    for name in ("consent", "nasa_tlx", "closing"):
        show_form(browser, name)
        observer.wait(lambda name=name: observer.all(f"[data-form={name}]"), f"no form {name}")
        assert violations(observer) == [], name
    show_form(browser, "")


def show_form(browser: Browser, name: str) -> None:
    browser.driver.execute_script("emitEvent('study', {do: 'form', name: arguments[0]})", name)


def test_a_question_is_answered_by_keyboard_alone_and_the_focus_stays_where_it_was(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    is_asked(browser)
    reached = []
    for _ in range(60):
        browser.key(Keys.TAB)
        reached.append(focused(browser))
        if reached[-1] == "t2":
            break
    assert {"stop_robot", "study", "keys"} <= set(reached), reached
    ring = "return getComputedStyle(document.activeElement.querySelector('.line')).strokeWidth"
    assert browser.driver.execute_script(ring) == "5px"
    label = browser.driver.execute_script("return document.activeElement.ariaLabel")
    assert label.startswith("2 t2: ")
    stage.others.ask(2)  # the picture is drawn again
    is_asked(browser, 2)
    assert focused(browser) == "t2"
    browser.key(Keys.ENTER)
    topic, msg = stage.others.next_sent()
    assert (topic, msg.object_id) == ("handed", "t2")


def test_caps_lock_is_no_other_key_and_a_key_without_a_meaning_does_nothing(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    is_asked(browser)
    # What a browser sends with Caps Lock on: capital letters without Shift, small ones with it.
    press = """document.body.dispatchEvent(new KeyboardEvent("keydown",
        {key: arguments[0], shiftKey: arguments[1], bubbles: true}))"""
    lines = browser.text(".log")
    for key in ("z", "j", "#", "9", "F2"):
        browser.driver.execute_script(press, key, False)
    browser.driver.execute_script(press, "C", False)
    topic, msg = stage.others.next_sent()
    assert (topic, msg.command) == ("gripper", m.WizardGripper.CLOSE)
    browser.driver.execute_script(press, "x", True)
    browser.wait(lambda: "Press again" in browser.text("[data-action=abort]"), "Shift and X with Caps Lock is no abort")
    assert browser.text(".log").count("no object") <= 1, lines  # 9: of four objects there is none with that number


def test_an_abort_that_is_not_confirmed_is_forgotten(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    browser.wait(lambda: browser.all("[data-action=abort]:not([disabled])"), "abort is not offered")
    browser.key("X")
    browser.wait(lambda: "Press again" in browser.text("[data-action=abort]"), "abort was not armed")
    browser.wait(lambda: "Press again" not in browser.text("[data-action=abort]"), "abort stays armed")
    stage.others.be_in(Phase.ABORTED)
    browser.wait(lambda: "Go on" in browser.text("[data-action=pause]"), "an abort cannot be taken back")
    browser.key("p")
    assert stage.others.next_sent()[1].command == m.WizardCommand.RESUME


def test_the_keys_are_shown_and_while_they_are_no_key_acts(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    browser.key("?")
    browser.wait(lambda: browser.all("#keys[open]"), "no keys")
    browser.says("#keys", "Abort")
    browser.key("c")
    browser.key(Keys.ESCAPE)
    browser.wait(lambda: not browser.all("#keys[open]"), "the keys stay")
    browser.key("o")
    assert stage.others.next_sent()[1].command == m.WizardGripper.OPEN


def test_a_marker_is_one_key_and_a_note_in_the_bag(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    browser.key("h")
    topic, msg = stage.others.next_sent()
    assert (topic, msg.text, msg.marker) == ("note", "hesitates", "hesitates")


def test_a_form_is_filled_in_by_keyboard_and_its_answers_are_published(stage: Stage, browse: Open):
    browser, observer = page_of(stage, browse), browse(f"{stage.address}/observe?lang=de")
    show_form(browser, "consent")
    observer.wait(lambda: observer.all("[data-form=consent]"), "no form")
    observer.wait(lambda: focused(observer) == "H2", "the form has not the focus")
    assert observer.driver.execute_script("return document.documentElement.lang") == "de"
    for key in (Keys.TAB, " ", Keys.TAB, " ", Keys.TAB, Keys.ARROW_DOWN, Keys.TAB, Keys.ENTER):
        observer.key(key)
    msg = stage.others.forms.get(timeout=60)
    assert (msg.form, msg.language, msg.declined, msg.session) == ("consent", "de", False, "stage")
    assert [(a.item, a.value) for a in msg.answers][:2] == [("informed", "yes"), ("takes_part", "yes")]
    assert msg.answers[2].value in ("yes", "no")
    observer.wait(lambda: "angekommen" in observer.text(".form-message"), "nobody says thanks")
    observer.wait(lambda: not observer.all("[data-form]"), "the form stays")
    stage.others.be_in(Phase.DEMONSTRATE)
    observer.wait(lambda: not observer.text(".form-message"), "the thanks stay although the session goes on")
    show_form(browser, "demographics")
    observer.wait(lambda: observer.all("[data-form=demographics]"), "no form")
    observer.press("[data-form=demographics] button[type=submit]")
    observer.says(".form-note", "noch offen", "what was left open is not said in the page's language")
    assert stage.others.forms.empty()
    observer.press("[data-decline]")
    assert stage.others.forms.get(timeout=60).declined


def test_the_participant_reads_no_id_and_hears_what_is_asked_when_the_switch_is_on(stage: Stage, browse: Open):
    observer = browse(f"{stage.address}/observe")
    observer.wait(lambda: observer.all(".speak:not([hidden])"), "no switch for speech")
    observer.driver.execute_script(
        "window.said = []; speechSynthesis.speak = (u) => window.said.push([u.lang, u.text]); localStorage.clear()"
    )
    observer.press("#speak")
    stage.others.ask(0)
    observer.wait(lambda: observer.all(".prompt.question"), "nothing is asked")
    words = observer.text(".observer")
    assert not {"s1", "t1", "hue_shift", "0.01"} & set(words.replace(".", " . ").split()), words
    observer.wait(lambda: observer.driver.execute_script("return window.said.length") >= 1, "nothing is said")
    observer.wait(
        lambda: "What shall I take" in observer.driver.execute_script("return window.said.at(-1)[1]"), "another is said"
    )


def test_a_lost_console_veils_the_pages_and_note_clock_and_forms_outlive_it(fresh_pages: Stage, browse: Open):
    stage = fresh_pages
    browser = page_of(stage, browse)
    stage.others.be_in(Phase.TUCK_AND_CLEAR)
    browser.wait(lambda: browser.phase() is Phase.TUCK_AND_CLEAR, "no phase")
    show_form(browser, "sus")
    browser.key("v")
    browser.wait(lambda: "being filled in" in browser.text(".study"), "the form is not shown")
    browser.key("t")
    browser.key("half a no")
    browser.wait(lambda: browser.driver.execute_script("return sessionStorage.getItem('keep:note')"), "nothing is kept")
    began = browser.text(".clock")
    stage.stop_console()
    browser.wait(lambda: shown(browser, "#veil"), "an old page looks as if it were not")
    browser.key("te")
    stage.start_console()
    browser.wait(lambda: "Connected again" in browser.text("#back"), "nobody says that it is back", timeout=120.0)
    note = "return document.querySelector('.note-input')?.value"
    browser.wait(lambda: browser.driver.execute_script(note) == "half a note", "the note is lost")
    browser.wait(lambda: browser.phase() is Phase.TUCK_AND_CLEAR, "no phase")
    browser.wait(lambda: "being filled in" in browser.text(".study"), "the form is forgotten")
    assert began.split()[0] != "–:––"


@pytest.fixture
def fresh_pages(tmp_path: Path) -> Iterator[Stage]:
    """A console of this test's own, with forms and a folder for what survives it."""
    with console_stage(tmp_path, {"forms": FORMS, "state_dir": str(tmp_path / "state")}) as running:
        running.rest()
        yield running


@pytest.mark.parametrize("size", [(1280, 800), (1024, 768), (768, 1024)])
def test_steps_and_events_are_in_view_on_laptop_and_tablet(stage: Stage, browse: Open, size: tuple[int, int]):
    browser = page_of(stage, browse)
    stage.others.ask(0)
    is_asked(browser)
    browser.resize(*size)
    inside = """const r = document.querySelector(arguments[0]).getBoundingClientRect();
        return r.top >= 0 && r.top + 80 <= innerHeight && r.right <= innerWidth + 1 && r.width > 200"""
    for selector in (".steps-panel", ".log-panel"):
        browser.wait(
            lambda s=selector: browser.driver.execute_script(inside, s), f"{selector} is out of view at {size}"
        )


def test_type_is_larger_on_a_large_screen(stage: Stage, browse: Open):
    browser = page_of(stage, browse)
    height = "return document.querySelector('.prompt .text').getBoundingClientRect().height"
    browser.resize(1280, 800)
    small = browser.driver.execute_script(height)
    browser.resize(1920, 1080)
    browser.wait(lambda: browser.driver.execute_script(height) >= 1.2 * small, "the type is as small")
    overflow = "return document.scrollingElement.scrollHeight - innerHeight"
    assert browser.driver.execute_script(overflow) <= 0
