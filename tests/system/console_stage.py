"""The console alone, with real messages from a stand-in for every other node."""

from __future__ import annotations

import contextlib
import queue
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rclpy
from console_browser import Browser, question_about
from console_session import free_port, wait_for_port
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import NodeSpec
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.live_session import install_prefixes
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.assists import Assist
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.objects import Role
from mbd_model.ros import conversions
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_model.session import Awaited, Phase, Prompt, PromptKind, SessionState
from mbd_msgs import msg as m
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo

Open = Callable[[str], Browser]
INTRINSICS = (600.0, 600.0, 320.0, 240.0)
WIZARD = {
    "gripper": m.WizardGripper,
    "demonstration": m.WizardDemonstration,
    "command": m.WizardCommand,
    "answer": m.WizardAnswer,
    "handed": m.WizardHanded,
    "pointed": m.WizardPointed,
    "overwrite": m.WizardOverwrite,
    "note": m.WizardNote,
    "revision": m.WizardRevision,
}


class Others(Node):
    """Publishes what a session would; ``sent`` holds what the console publishes, as (topic, message), and ``forms``."""

    def __init__(self, **options: Any) -> None:
        super().__init__("others", **options)
        self.sent: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self.forms: queue.SimpleQueue[m.FilledForm] = queue.SimpleQueue()
        self.create_subscription(m.FilledForm, "study/form", self.forms.put, EVENTS)
        kinds = {
            "interaction/state": m.SessionState,
            "interaction/prompt": m.Prompt,
            "perception/target_scene": m.Scene,
            "demonstration/task": m.Task,
            "mapping/estimate": m.MappingEstimate,
        }
        self.out = {topic: self.create_publisher(kind, topic, LATCHED) for topic, kind in kinds.items()}
        self._replies = self.create_publisher(m.WizardReply, "interaction/replies", EVENTS)
        self._camera = self.create_publisher(CameraInfo, "camera/color/camera_info", SENSOR)
        self.create_timer(0.2, self._look)
        self._wizard = [
            self.create_subscription(kind, f"wizard/{name}", lambda msg, name=name: self.sent.put((name, msg)), EVENTS)
            for name, kind in WIZARD.items()
        ]

    def connected(self) -> bool:
        """Whether the console and this node receive each other's messages."""
        received = all(p.get_subscription_count() for p in self.out.values())
        return received and all(s.get_publisher_count() for s in self._wizard)

    def wait_for(self, done: Callable[[], bool], timeout: float = 60.0) -> None:
        """Until it is so."""
        end = time.monotonic() + timeout
        while not done():
            assert time.monotonic() < end, "waited in vain"
            time.sleep(0.02)

    def _look(self) -> None:
        fx, fy, cx, cy = INTRINSICS
        k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
        self._camera.publish(CameraInfo(width=640, height=480, k=k))

    def ask(self, step_index: int, assists: tuple[Assist, ...] = ()) -> None:
        """Be in ASSIST and ask about a step: even ones are picks, odd ones places."""
        task = stacking_task(4)
        step = task.steps[step_index]
        kind = PromptKind.WHAT_DO_I_USE if step_index % 2 == 0 else PromptKind.WHERE_DO_I_GO
        words = "What do I use now?" if step_index % 2 == 0 else "Where do I go next?"
        estimate = MappingEstimate("mbd", Mapping((("s1", "t1"), ("s2", "t2"))), 0.01, (Feature.SIZE,))
        self.out["demonstration/task"].publish(conversions.task_to_msg(task))
        self.out["perception/target_scene"].publish(conversions.scene_to_msg(row_of_objects(Role.TARGET, "t", 4)))
        stamps = (conversions.time_to_msg(1.0),) * 3
        estimated = conversions.estimate_to_msg(estimate, session="stage", threshold=0.02, stamps=stamps)
        self.out["mapping/estimate"].publish(estimated)
        prompt = Prompt(kind, words, step_index, step.primary_object)
        self.out["interaction/prompt"].publish(conversions.prompt_to_msg(prompt, 1.0))
        self.be_in(Phase.ASSIST, step_index=step_index, assists=assists)

    def ask_whether(self, kind: PromptKind, awaiting: Awaited, text: str, *targets: str) -> None:
        """Ask about the first step by naming target objects, t3 having been given for it and being doubted."""
        given = (Assist("s1", "t3", 0),)
        self.ask(0, given)
        pairs = Mapping((("s1", "t1"), ("s2", "t2")), 0.7)
        obeying = Mapping((("s1", "t3"), ("s2", "t2")), 0.2)
        estimate = MappingEstimate(
            "evidence", pairs, 0.7, (Feature.SIZE,), best_guess=pairs, obeying=obeying, doubted=given[0], doubt=0.8
        )
        stamps = (conversions.time_to_msg(1.0),) * 3
        estimated = conversions.estimate_to_msg(estimate, session="stage", threshold=0.5, stamps=stamps)
        self.out["mapping/estimate"].publish(estimated)
        self.out["interaction/prompt"].publish(conversions.prompt_to_msg(Prompt(kind, text, 0, "s1", targets), 1.0))
        self.be_in(Phase.ASSIST, step_index=0, assists=given, awaiting=awaiting)

    def be_in(self, phase: Phase, **also: Any) -> None:
        """Be in a phase."""
        state = SessionState("stage", phase, **also)
        self.out["interaction/state"].publish(conversions.state_to_msg(state, 1.0))

    def reply(self, topic: str, accepted: bool, reason: str) -> None:
        """Answer a wizard event."""
        self._replies.publish(m.WizardReply(topic=topic, accepted=accepted, reason=reason))

    def next_sent(self, timeout: float = 60.0) -> tuple[str, Any]:
        """The next thing the console publishes."""
        return self.sent.get(timeout=timeout)


class Stage:
    """The stand-in, and the console's process and address; ``sentence``: the robot's prompt while the stage rests."""

    def __init__(self, others: Others, processes: SessionProcesses, port: int) -> None:
        self.others, self.processes, self.port = others, processes, port
        self.sentence = ""
        self._rests = 0

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def rest(self) -> None:
        """Go back to the first phase, nothing asked or assisted; notes published once inform the pages that show it."""
        self._rests += 1
        self.sentence = f"This is rest number {self._rests}."
        self.others.out["interaction/prompt"].publish(
            conversions.prompt_to_msg(Prompt(PromptKind.INFORM, self.sentence), 1.0)
        )
        self.others.be_in(Phase.OBSERVE_SOURCE)
        with contextlib.suppress(queue.Empty):
            while True:
                self.others.sent.get_nowait()

    def stop_console(self) -> None:
        """Kill the console as ``kill -9`` would."""
        console = self.processes["console"].process
        console.kill()
        console.wait()

    def start_console(self) -> None:
        """Start it again after it was killed."""
        self.processes.start(self.processes["console"].spec)
        wait_for_port(self.port, self.processes)

    def kill_console(self) -> None:
        """Kill the console as ``kill -9`` would, and start it again."""
        self.processes.restart("console")
        wait_for_port(self.port, self.processes)


@contextlib.contextmanager
def console_stage(
    folder: Path, parameters: dict[str, Any] | None = None, beside: tuple[NodeSpec, ...] = ()
) -> Iterator[Stage]:
    """Start the console with the stand-in beside it, in a ROS domain of their own.

    Args:
        folder: for what they write.
        parameters: more of the console's.
        beside: nodes that are no stand-ins.
    """
    port = free_port()
    with contextlib.ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        others = Others(context=context)
        stack.callback(spin_in_background(others))
        environment = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        prefixes = install_prefixes(["mbd_console", *{spec.package for spec in beside}])
        processes = stack.enter_context(SessionProcesses(prefixes, folder / "logs", environment))
        for spec in (*beside, NodeSpec("mbd_console", "console", {"port": port, **(parameters or {})})):
            processes.start(spec)
        wait_for_port(port, processes)
        end = time.monotonic() + 60
        while not others.connected():
            assert time.monotonic() < end, f"the console receives nothing:\n{processes['console'].log_tail()}"
            time.sleep(0.05)
        yield Stage(others, processes, port)


def page_of(stage: Stage, browse: Open, path: str = "") -> Browser:
    """A page that shows the stage at rest."""
    browser = browse(stage.address + path)
    if path == "/observe":  # in lay words: neither the robot's own sentence nor the phases
        browser.wait(lambda: "lay out the first things" in browser.text(".prompt"), "the page does not show the phase")
        return browser
    browser.wait(lambda: stage.sentence in browser.text(".prompt"), "the page does not show what the robot states")
    browser.wait(lambda: browser.phase() is Phase.OBSERVE_SOURCE, "the page does not show the phase")
    return browser


def is_asked(browser: Browser, step: int = 0) -> None:
    """Until a page shows the question and the step it is about: they come on two topics."""
    browser.wait(lambda: browser.all(question_about(step)), f"the page does not ask about step {step}")
    browser.wait(lambda: browser.all(f".step.asked[data-step='{step}']"), f"step {step} is not marked as asked")
    browser.wait(lambda: browser.all(".choosing"), "nothing to choose")
