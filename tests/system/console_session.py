"""A session whose wizard sits at the console: his head is the scripted wizard's, his hands are a browser's."""

from __future__ import annotations

import contextlib
import queue
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import rclpy
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import CELL_CAMERA, NodeSpec, SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.live_session import install_prefixes
from mbd_cell.ros.wizard_node import WizardNode
from mbd_cell.teacher.wizard import WizardAct, WizardEvent
from mbd_model.session import Phase
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import WebDriverWait

CHROMIUM, DRIVER = Path("/usr/bin/chromium"), Path("/usr/bin/chromedriver")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
)
# Every other press is a key, every other a click.
KEY = {
    WizardAct.OPEN: "o",
    WizardAct.CLOSE: "c",
    WizardAct.START: "s",
    WizardAct.STOP: "e",
    WizardAct.NEXT_PHASE: "n",
    WizardAct.SKIP: "k",
    WizardAct.YES: "y",
    WizardAct.NO: "w",
}
BUTTON = {
    WizardAct.OPEN: "open",
    WizardAct.CLOSE: "close",
    WizardAct.START: "start",
    WizardAct.STOP: "stop",
    WizardAct.NEXT_PHASE: "next",
    WizardAct.SKIP: "skip",
    WizardAct.YES: "yes",
    WizardAct.NO: "no",
}


def question_about(step: int) -> str:
    """Selector of the banner while it asks about a step, counted from 0."""
    return f".prompt.question[data-step='{step}']"


class Browser:
    """A headless Chromium with one console page."""

    def __init__(self, address: str, profile: Path, size: tuple[int, int] = (1280, 800)) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = str(CHROMIUM)
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(DRIVER)))
        self.show(address, size)

    def show(self, address: str, size: tuple[int, int] = (1280, 800)) -> None:
        """Open another page in place of the one it has."""
        self.resize(*size)
        self.driver.get(address)

    def close(self) -> None:
        self.driver.quit()

    def resize(self, width: int, height: int) -> None:
        """Make the page, not the window, that large [px]."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )

    def all(self, selector: str) -> list[WebElement]:
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        """All text of the elements there, whether scrolled into view or not; read at once, as panels are replaced."""
        script = "return [...document.querySelectorAll(arguments[0])].map(e => e.textContent).join('\\n')"
        return str(self.driver.execute_script(script, selector))

    def wait(self, what: Callable[[], object], why: str, timeout: float = 60.0) -> None:
        # The page is drawn again while it is read: what has gone then is looked for again.
        waiting = WebDriverWait(self.driver, timeout, 0.1, ignored_exceptions=[StaleElementReferenceException])
        waiting.until(lambda _: what(), why)

    def says(self, selector: str, text: str, why: str = "") -> None:
        """Until that text is among the elements there: a page just opened is drawn again as messages come in."""
        self.wait(lambda: text in self.text(selector), why or f"{selector!r} does not come to say {text!r}")

    def press(self, selector: str, number: int = 0) -> None:
        """Click one of the elements there, found again if the page is drawn between finding and clicking."""

        def click() -> bool:
            found = self.all(selector)
            if len(found) <= number:
                return False
            found[number].click()
            return True

        self.wait(click, f"no {selector!r} number {number} to click")

    def key(self, key: str) -> None:
        webdriver.ActionChains(self.driver).send_keys(key).perform()

    def click(self, action: str) -> None:
        self.press(f"[data-action={action}]:not([disabled])")

    def click_object(self, object_id: str) -> None:
        self.press(f".choosing [data-object={object_id}] .name")

    def phase(self) -> Phase | None:
        """The phase the page shows as the present one."""
        script = "return document.querySelector('.phases .now')?.dataset.phase"
        name = self.driver.execute_script(script)
        return Phase[name] if name else None

    def note(self, text: str) -> None:
        self.key("t")
        self.key(text + Keys.ENTER)


class PressingWizard(WizardNode):
    """Decides what the scripted wizard would, and leaves it to somebody else to do it."""

    def __init__(self, **options: object) -> None:
        super().__init__()
        self.requests: queue.SimpleQueue[tuple[WizardEvent, Phase | None]] = (
            queue.SimpleQueue()
        )  # with the phase it is for

    def _send(self, request: WizardEvent) -> None:
        self.requests.put((request, self.wizard.state.phase if self.wizard.state else None))


class ConsoleSession:
    """Every node of a session but the scripted wizard, and the console. Use ``console_session``."""

    def __init__(self, processes: SessionProcesses, wizard: PressingWizard, port: int) -> None:
        self.processes, self.wizard, self.port = processes, wizard, port
        self._presses = 0

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def phase(self) -> Phase | None:
        state = self.wizard.wizard.state
        return state.phase if state else None

    @property
    def asked_step(self) -> int:
        """The step the robot asks about, counted from 0; -1 while it asks nothing."""
        prompt = self.wizard.wizard.prompt
        return prompt.step_index if prompt else -1

    def lead(self, browser: Browser, until: Callable[[], bool], timeout: float = 400.0) -> None:
        """Press what the wizard decides, by click and key in turn, until something is so."""
        end = time.monotonic() + timeout
        while not until():
            for node in self.processes.dead():
                raise AssertionError(f"{node.name} died:\n{node.log_tail()}")
            assert time.monotonic() < end, f"phase {self.phase}; the page states: {browser.text('.banner, .reply')}"
            try:
                request, phase = self.wizard.requests.get(timeout=0.1)
            except queue.Empty:
                continue
            if until():
                self.wizard.requests.put((request, phase))  # for when leading goes on
                return
            self.press(browser, request, phase)

    def press(self, browser: Browser, request: WizardEvent, phase: Phase | None) -> None:
        self._presses += 1
        by_key = self._presses % 2 == 0
        if request.act in (WizardAct.HANDED, WizardAct.POINTED):
            step = self.wizard.wizard.prompt.step_index
            browser.wait(lambda: browser.all(f".step.asked[data-step='{step}']"), "the page asks about another step")
            # The question and the step come on two topics, and a page's answer names its question.
            browser.wait(lambda: browser.all(question_about(step)), f"the page does not ask about step {step}")
            objects = self.wizard.wizard.scenes
            ids = next(s.ids for s in objects.values() if request.object_id in s.ids)
            browser.key(str(ids.index(request.object_id) + 1)) if by_key else browser.click_object(request.object_id)
            return
        offered = f"[data-action={BUTTON[request.act]}]:not([disabled])"
        browser.wait(lambda: browser.all(offered) or self.phase is not phase, f"the page does not offer {request}")
        if self.phase is not phase or not browser.all(offered):
            # Decided just before the phase changed: of no use any more, and a scripted wizard would be refused.
            self.wizard.wizard.reply(request.act.topic, False, time.monotonic())
        elif by_key:
            browser.key(KEY[request.act])
        else:
            browser.click(BUTTON[request.act])


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def console_session(options: SessionOptions) -> Iterator[ConsoleSession]:
    """Start it in a ROS domain of its own, and end it."""
    port = free_port()
    specs = [s for s in session_nodes(options) if s.executable not in ("wizard", "console", "markers")]
    console = NodeSpec("mbd_console", "console", {"use_sim_time": True, "port": port}, config=(CELL_CAMERA,))
    with contextlib.ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        # The wizard node makes its own node in the default context.
        rclpy.init(args=["--ros-args", "-p", "use_sim_time:=true"], domain_id=domain)
        stack.callback(rclpy.try_shutdown)
        wizard = PressingWizard()
        stack.callback(spin_in_background(wizard))
        prefixes = install_prefixes(["mbd_cell", *{s.package for s in (*specs, console)}])
        environment = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        processes = stack.enter_context(SessionProcesses(prefixes, options.folder / "logs", environment))
        for spec in (*specs, console):
            processes.start(spec)
        wait_for_port(port, processes)
        yield ConsoleSession(processes, wizard, port)


def wait_for_port(port: int, processes: SessionProcesses, timeout: float = 120.0) -> None:
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
            return
        for node in processes.dead():
            raise AssertionError(f"{node.name} died:\n{node.log_tail()}")
        time.sleep(0.1)
    raise AssertionError(f"the console does not listen on port {port}:\n{processes['console'].log_tail()}")
