"""The page of the demonstrated steps in a real browser: what was shown, and every correction by click and by key."""

from __future__ import annotations

import re
import urllib.request
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from accessibility import needs_axe, prefer, violations
from console_browser import CHROMIUM, DRIVER, Browser
from console_stage import Open, Stage
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.ros.conversions import prompt_to_msg, task_to_msg, time_from_msg, time_to_msg
from mbd_model.ros.qos import SENSOR
from mbd_model.session import Awaited, Phase, Prompt, PromptKind
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.times import to_nanoseconds
from mbd_msgs import msg as m
from selenium.webdriver.common.keys import Keys
from sensor_msgs.msg import Image

pytestmark = [
    pytest.mark.timeout(300),
    pytest.mark.skipif(
        not (CHROMIUM.exists() and DRIVER.exists()), reason="needs a browser: apt-get install chromium chromium-driver"
    ),
]
WORDS = {"s1": ("red", "bowl"), "s2": ("", "plate"), "s3": ("blue", "cup"), "s4": ("red", "cup")}
DONE = "the step was corrected by the teacher"


def shown_task() -> Task:
    """The red bowl onto the plate; the blue cup, or the red one, into the bowl, taken again and put onto the plate."""
    things = tuple(
        SceneObject(i, (0.5, 0.2 * k, 0.05), (0.08, 0.08, 0.1), color_name=color, object_class=kind)
        for k, (i, (color, kind)) in enumerate(WORDS.items())
    )
    ends = (12.0, 15.0, 18.0, 21.0, 23.0, 26.0)
    about = ("s1", "s2", "s3", "s1", "s3", "s2")
    kinds = (StepKind.PICK, StepKind.PLACE) * 3
    steps = [
        TaskStep(k, kind, i, 0.0, start=([10.0, *ends])[k], end=at)
        for k, (kind, i, at) in enumerate(zip(kinds, about, ends, strict=True))
    ]
    steps[2] = replace(steps[2], runner_up="s4", runner_up_distance=0.002, doubt=0.32)
    return Task(Scene(Role.SOURCE, things, 5.0), tuple(steps), ("step 9 was shown twice: <b>not</b> a step",), 30.0)


def film(stage: Stage, moments: dict[float, tuple[int, int, int]]) -> None:
    """The camera sees one colour at each moment [s] of the demonstration; each is sent until it came."""
    camera = stage.others.create_publisher(Image, "camera/color/image_raw", SENSOR)
    for stamp, color in moments.items():
        pixels = np.zeros((120, 160, 3), np.uint8)
        pixels[:] = color
        picture = Image(height=120, width=160, encoding="rgb8", step=480, data=pixels.tobytes())
        picture.header.stamp = time_to_msg(stamp)
        address = f"{stage.address}/moment/{to_nanoseconds(stamp)}"

        def came(picture: Image = picture, address: str = address) -> bool:
            camera.publish(picture)
            with urllib.request.urlopen(address) as answer:
                return answer.headers["Content-Type"] == "image/jpeg"

        stage.others.wait_for(came)
    stage.others.destroy_publisher(camera)


def steps_page(stage: Stage, browse: Open, phase: Phase = Phase.TUCK_AND_CLEAR, language: str = "en") -> Browser:
    """The page of the steps of the task that was shown."""
    task = shown_task()
    stage.others.out["demonstration/task"].publish(task_to_msg(task))
    stage.others.be_in(phase, awaiting=Awaited.NEXT_PHASE)
    browser = browse(f"{stage.address}/steps?lang={language}")
    browser.wait(lambda: len(browser.all(".carry")) == 3, "the page does not show three carries")
    return browser


def pressed(stage: Stage, browser: Browser, name: str, press: Callable[[], None]) -> m.WizardRevision:
    """What the console publishes on the press of a correction's button."""
    browser.wait(lambda: browser.all(f"[data-correction='{name}']"), f"no button {name}")
    press()
    topic, msg = stage.others.next_sent()
    assert topic == "revision"
    return msg


def by_click(browser: Browser, name: str) -> Callable[[], None]:
    def press() -> None:
        browser.press(f"[data-correction='{name}']")

    return press


def by_key(browser: Browser, name: str) -> Callable[[], None]:
    """Tab to it and press Enter, as one without a mouse does."""

    def press() -> None:
        for _ in range(80):
            browser.key(Keys.TAB)
            focused = "return document.activeElement.dataset.correction ?? document.activeElement.tagName"
            if browser.driver.execute_script(focused) == name:
                browser.key(Keys.ENTER)
                return
        pytest.fail(f"the keyboard does not reach {name}")

    return press


def test_each_step_is_a_sentence_with_the_pictures_of_its_moments(stage: Stage, browse: Open):
    stage.others.be_in(Phase.DEMONSTRATE)
    page = browse(stage.address)
    page.wait(lambda: page.phase() is Phase.DEMONSTRATE, "the page does not show the phase")
    seen = {11.9: (200, 30, 30), 12.95: (20, 20, 20), 15.1: (30, 200, 30), 18.0: (30, 30, 200)}
    film(stage, seen)
    browser = steps_page(stage, browse)
    sentences = (
        "1. Pick the red bowl, put it onto the plate.",
        "2. Pick the blue cup, put it onto the red bowl.",
        "3. Pick the blue cup, put it onto the plate.",
    )
    browser.says(".sentence", "\n".join(sentences))
    browser.says("figcaption", "picked after 2.0 s\nlet go after 5.0 s")
    color = """
        const image = document.querySelectorAll('.moments img')[arguments[0]];
        if (!image.complete || !image.naturalWidth) return null;
        const canvas = document.createElement('canvas'); canvas.width = canvas.height = 1;
        const context = canvas.getContext('2d'); context.drawImage(image, 0, 0, 1, 1);
        return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);"""
    for number, stamp in ((0, 11.9), (1, 15.1), (2, 18.0)):
        browser.wait(lambda k=number: browser.driver.execute_script(color, k), f"picture {number} does not load")
        assert browser.driver.execute_script(color, number) == pytest.approx(seen[stamp], abs=12)
    browser.says(".noted", "step 9 was shown twice: <b>not</b> a step")


@needs_axe
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_in_german_no_english_word_is_left_and_axe_finds_nothing_wrong(stage: Stage, browse: Open, scheme: str):
    browser = steps_page(stage, browse, language="de")
    prefer(browser, scheme)
    assert browser.driver.execute_script("return document.documentElement.lang") == "de"
    browser.says(".sentence", "1. Die rote Schüssel nehmen, auf den Teller legen.")
    browser.says(".doubt-of-step", "Unklar: der blaue Becher oder der rote Becher (32%)?")
    browser.driver.execute_script("document.querySelectorAll('details').forEach(e => e.open = true)")
    named = """return [...document.querySelectorAll('.carry [title], .carry [aria-label], .carry img')]
        .map(e => [e.title, e.ariaLabel, e.alt].join(' ')).join(' ')"""
    parts = ".stop-bar .q-btn, h1, h2, nav a, .back, .sentence, figcaption, .q-btn, summary, .doubt-of-step > *"
    shown = f"{browser.text(parts)} {browser.driver.execute_script(named)}"
    words = set(re.findall(r"[a-zäöü]+", shown.lower()))
    assert {"löschen", "früher", "teilen"} < words
    assert not words & {"the", "step", "pick", "put", "after", "delete", "earlier", "later", "seconds", "cup", "bowl"}
    assert violations(browser) == []


def test_every_correction_is_a_button_reached_by_click_and_by_key(stage: Stage, browse: Open):
    browser = steps_page(stage, browse)
    change = m.WizardRevision
    sent = pressed(stage, browser, "MOVE-2-0", by_click(browser, "MOVE-2-0"))
    assert (sent.change, sent.step, sent.to) == (change.MOVE, 2, 0)
    sent = pressed(stage, browser, "MOVE-0-4", by_key(browser, "MOVE-0-4"))
    assert (sent.change, sent.step, sent.to) == (change.MOVE, 0, 4)
    sent = pressed(stage, browser, "JOIN-3-0", by_key(browser, "JOIN-3-0"))
    assert (sent.change, sent.step) == (change.JOIN, 3)
    labels = ("Another object was picked …", "It was put onto another …", "It was put down on the way …")
    browser.says(".choice summary", "\n".join(labels))
    browser.press(".choice summary", 1)
    sent = pressed(stage, browser, "CHANGE_OBJECT-1-s4", by_click(browser, "CHANGE_OBJECT-1-s4"))
    assert (sent.change, sent.step, sent.object) == (change.CHANGE_OBJECT, 1, "s4")
    browser.press(".choice summary", 2)
    sent = pressed(stage, browser, "SPLIT-1", by_click(browser, "SPLIT-1"))
    assert (sent.change, sent.step, time_from_msg(sent.at)) == (change.SPLIT, 1, pytest.approx(13.5))
    for name, code in (("DELETE-4-0", change.DELETE), ("RERECORD-2-0", change.RERECORD)):
        by_click(browser, name)()
        browser.wait(lambda n=name: "Press again" in browser.text(f"[data-correction='{n}']"), "asked for once only")
        sent = pressed(stage, browser, name, by_click(browser, name))
        assert sent.change == code
    stage.others.reply("/wizard/revision", True, DONE)
    browser.wait(lambda: DONE in browser.text(".answer"), "what became of it is not shown")


def test_a_step_in_doubt_is_shown_with_both_objects_and_settled_by_a_press(stage: Stage, browse: Open):
    browser = steps_page(stage, browse)
    # The page tells of the task before it is told that the phase is one in which steps are corrected.
    browser.says(".doubt-of-step", "In doubt: the blue cup, or the red cup (32%)?")
    sent = pressed(stage, browser, "CHANGE_OBJECT-2-s3", by_click(browser, "CHANGE_OBJECT-2-s3"))
    assert (sent.step, sent.object) == (2, "s3")
    task = shown_task()
    settled = replace(task, steps=tuple(replace(s, doubt=0.0) for s in task.steps))
    stage.others.out["demonstration/task"].publish(task_to_msg(settled))
    browser.wait(lambda: not browser.all(".doubt-of-step"), "the doubt is still shown")


def test_the_console_asks_which_was_meant_and_takes_a_click_or_a_number(stage: Stage, browse: Open):
    task = shown_task()
    browser = browse(stage.address)

    def click() -> None:
        browser.press(".candidates button", 1)

    for number, press in enumerate((click, lambda: browser.key("2"))):
        text = f"Did you pick the blue cup or the red cup? (step 3) {number}"
        stage.others.out["demonstration/task"].publish(task_to_msg(task))
        prompt = Prompt(PromptKind.WHICH_WAS_MEANT, text, 2, "s3", source_ids=("s3", "s4"))
        stage.others.out["interaction/prompt"].publish(prompt_to_msg(prompt, 1.0))
        stage.others.be_in(Phase.TUCK_AND_CLEAR, step_index=2, awaiting=Awaited.NEXT_PHASE)
        browser.says(".prompt.question", text)
        browser.says(".candidates", "the red cup")
        press()
        topic, msg = stage.others.next_sent()
        assert (topic, msg.object_id) == ("pointed", "s4")


def test_no_step_can_be_corrected_once_the_robot_goes_on_alone(stage: Stage, browse: Open):
    browser = steps_page(stage, browse, Phase.EXECUTE)
    browser.says(".closed", "Nothing can be corrected now")
    assert not browser.all("[data-correction]")
