"""A session whose wizard sits at the console: his head is the scripted wizard's, his hands are a browser's."""

from __future__ import annotations

import contextlib
import queue
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import rclpy
from console_browser import Browser, question_about
from console_hands import BUTTON, Hand
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import CELL_CAMERA, NodeSpec, SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.live_session import install_prefixes
from mbd_cell.ros.wizard_node import WizardNode
from mbd_cell.teacher.wizard import WizardAct, WizardEvent
from mbd_model.session import Phase

# A page that is slow to show something, or comes back, delays a press: decided a second time it would be pressed twice.
PATIENCE = 180.0  # [s]


class PressingWizard(WizardNode):
    """Decides what the scripted wizard would, and leaves it to somebody else to do it."""

    def __init__(self, **options: object) -> None:
        super().__init__()
        self.wizard.reply_timeout = PATIENCE
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
        self.hand: Hand | None = None  # None: mouse and keys in turn

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

    def lead(self, *browsers: Browser, until: Callable[[], bool], timeout: float = 400.0) -> None:
        """Press what the wizard decides, on one page after the other, until something is so."""
        end = time.monotonic() + timeout
        while not until():
            for node in self.processes.dead():
                raise AssertionError(f"{node.name} died:\n{node.log_tail()}")
            assert time.monotonic() < end, f"phase {self.phase}; the page states: {browsers[0].text('.banner, .reply')}"
            try:
                request, phase = self.wizard.requests.get(timeout=0.1)
            except queue.Empty:
                continue
            if until():
                self.wizard.requests.put((request, phase))  # for when leading goes on
                return
            self.press(browsers[self._presses % len(browsers)], request, phase)

    def press(self, browser: Browser, request: WizardEvent, phase: Phase | None) -> None:
        self._presses += 1
        hand = self.hand or (Hand.KEYS if self._presses % 2 == 0 else Hand.MOUSE)
        if request.act in (WizardAct.HANDED, WizardAct.POINTED):
            step = self.wizard.wizard.prompt.step_index
            browser.wait(lambda: browser.all(f".step.asked[data-step='{step}']"), "the page asks about another step")
            # The question and the step come on two topics, and a page's answer names its question.
            browser.wait(lambda: browser.all(question_about(step)), f"the page does not ask about step {step}")
            objects = self.wizard.wizard.scenes
            ids = next(s.ids for s in objects.values() if request.object_id in s.ids)
            hand.choose(browser, request.object_id, ids.index(request.object_id) + 1)
            return
        offered = f"[data-action={BUTTON[request.act]}]:not([disabled])"
        browser.wait(lambda: browser.all(offered) or self.phase is not phase, f"the page does not offer {request}")
        if self.phase is not phase or not browser.all(offered):
            # Decided just before the phase changed: of no use any more, and a scripted wizard would be refused.
            self.wizard.wizard.reply(request.act.topic, False, time.monotonic())
        else:
            hand.do(browser, request.act)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def console_session(options: SessionOptions) -> Iterator[ConsoleSession]:
    """Start it in a ROS domain of its own, and end it."""
    port = free_port()
    specs = [s for s in session_nodes(options) if s.executable not in ("wizard", "console", "markers")]
    # Nothing moves while a page is read and pressed: four pictures a second would take most of a core, rendered,
    # looked through, recorded and shown.
    cell = next(s for s in specs if s.executable == "cell")
    specs[specs.index(cell)] = replace(cell, parameters={**cell.parameters, "camera_rate": 1.0})
    kept = str(options.folder / "console_state")  # the scenes' photographs outlive it there
    parameters: dict[str, Any] = {"use_sim_time": True, "port": port, "state_dir": kept}
    if options.forms:
        parameters["forms"] = list(options.forms)
    console = NodeSpec("mbd_console", "console", parameters, config=(CELL_CAMERA,))
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
