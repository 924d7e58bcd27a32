"""A hand on the stop, in a real browser: one key on every page, and a button; going on takes two presses."""

from __future__ import annotations

import pytest
from console_browser import CHROMIUM, DRIVER, Browser
from console_stage import Open, Stage
from mbd_model.ros.stop_line import StopLine
from mbd_model.session import Awaited, Phase
from mbd_model.stop import StopCause
from mbd_msgs import msg as m
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

pytestmark = [
    pytest.mark.timeout(300),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]


def follow(stage: Stage) -> StopLine:
    """A robot that follows the stop of the console."""
    line = StopLine(stage.others, serve=False)
    stage.others.wait_for(lambda: stage.others.count_publishers("stop") > 1)
    return line


def shown(browser: Browser, text: str) -> None:
    browser.wait(lambda: text in browser.text(".standing"), f"the page does not say: {text}")


@pytest.mark.parametrize("path", ["/", "/steps", "/observe"])
def test_the_key_stops_from_every_page_and_the_page_says_why(fresh_stage: Stage, browse: Open, path: str):
    line = follow(fresh_stage)
    fresh_stage.others.be_in(Phase.DEMONSTRATE, awaiting=Awaited.DEMONSTRATION_START)
    browser = browse(f"{fresh_stage.address}{path}")
    browser.wait(lambda: browser.all(".stop-bar"), "there is no stop on the page")
    ActionChains(browser.driver).send_keys(Keys.F8).perform()
    fresh_stage.others.wait_for(lambda: line.latch.held)
    assert line.latch.cause is StopCause.PERSON
    shown(browser, "Whoever leads the session" if path == "/observe" else "A hand on the console")
    if path == "/observe":  # a tablet has no such key
        line.release()
        browser.wait(lambda: not browser.text(".standing"), "the page still says that it stands")
        browser.click("stop_robot")
        fresh_stage.others.wait_for(lambda: line.latch.held)


def test_the_button_stops_a_note_being_typed_does_not_keep_the_key_and_resume_is_pressed_twice(
    fresh_stage: Stage, browse: Open
):
    line = follow(fresh_stage)
    fresh_stage.others.be_in(Phase.DEMONSTRATE, awaiting=Awaited.DEMONSTRATION_START)
    browser = browse(fresh_stage.address)
    browser.wait(lambda: browser.all(".note-input"), "there is no page")
    browser.key("t")
    ActionChains(browser.driver).send_keys("half a no").send_keys(Keys.F8).perform()
    fresh_stage.others.wait_for(lambda: line.latch.held)
    shown(browser, "A hand on the console")
    value = "return document.querySelector('.note-input')?.value"
    browser.wait(lambda: browser.driver.execute_script(value) == "half a no", "what was being typed is gone")
    browser.click("pause")
    browser.wait(lambda: "Press again" in browser.text("[data-action=pause]"), "one press was taken")
    browser.click("pause")
    topic, sent = fresh_stage.others.next_sent()
    assert topic.endswith("command") and sent.command == m.WizardCommand.RESUME
    line.release()
    browser.wait(lambda: not browser.text(".standing"), "the page still says that it stands")
    browser.click("stop_robot")
    fresh_stage.others.wait_for(lambda: line.latch.held)
