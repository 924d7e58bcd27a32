"""A complete session in which every sentence is another one when it arrives: nobody needs the words."""

from __future__ import annotations

import contextlib
import queue
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import rclpy
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.ros.background import spin_in_background
from mbd_bringup.ros.follow import SessionFollower
from mbd_bringup.ros.live_session import install_prefixes
from mbd_console.actions import Action, offered
from mbd_console.ros.console_node import ConsoleNode
from mbd_model.session import Awaited, Phase, SessionState
from rclpy.node import Node
from rewording import REWORDINGS, without_sentences
from rewording_relay import PLAIN, TOPICS, RewordedProcesses, RewordingRelay

pytestmark = pytest.mark.timeout(400)
WORDS = REWORDINGS["reversed"]
NO_PICTURES = [f"camera/color/{name}:=nowhere/{name}" for name in ("image_raw", "camera_info")]
IN_ITS_OWN_WORDS = [f"{topic}:={PLAIN}/{topic}" for topics in TOPICS.values() for topic in topics]


def remapped(rules: list[str]) -> list[str]:
    return ["--ros-args", *(word for rule in rules for word in ("-r", rule))]


class RewordedSession:
    """Every node of a session but the recorder; in this process two consoles, one of which receives the own words."""

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        options = SessionOptions("reworded", folder, task="stacking", seed=2, threshold=1.0, speed=0.0, execute=True)
        specs = [s for s in session_nodes(options) if s.executable != "recorder"]
        # Words are what this is about: looking again would only take its time.
        specs = [
            replace(s, parameters={**s.parameters, "look_again": False}) if s.executable == "execution" else s
            for s in specs
        ]
        domain = stack.enter_context(private_domain())

        def spun(kind: type[Node], *words: Any, **more: Any) -> Any:
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=domain)
            node = kind(*words, context=context, **more)
            stack.callback(spin_in_background(node))
            return node

        self.relay: RewordingRelay = spun(RewordingRelay, WORDS)
        self.follower: SessionFollower = spun(SessionFollower)
        self.plain: ConsoleNode = spun(ConsoleNode, cli_args=remapped([*NO_PICTURES, *IN_ITS_OWN_WORDS]))
        self.other: ConsoleNode = spun(ConsoleNode, cli_args=remapped(NO_PICTURES))
        environment = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        packages = {s.package for s in specs} | {package for s in specs for package, _ in s.config if package}
        prefixes = install_prefixes(sorted(packages))
        self.processes = stack.enter_context(RewordedProcesses(prefixes, folder / "logs", environment))
        for spec in specs:
            self.processes.start(spec)

    def until_done(self, timeout: float = 300.0) -> Iterator[None]:
        """Comes back after each thing that happens until the session is over."""
        end, phase = time.monotonic() + timeout, None
        while phase not in (Phase.DONE, Phase.ABORTED):
            assert time.monotonic() < end, f"the session is still in {phase}"
            for node in self.processes.dead():
                raise AssertionError(f"{node.name} died:\n{node.log_tail()}")
            with contextlib.suppress(queue.Empty):
                phase = self.follower.events.get(timeout=0.02).phase or phase
            yield


Offers = dict[tuple[SessionState, int], frozenset[Action]]


def remember(console: ConsoleNode, offers: Offers) -> None:
    """What a console offers now, by what it has received but for the sentences."""
    console.desk.catch_up()
    state = console.desk.state
    if state.session is not None:
        steps = len(state.task.steps) if state.task else 0
        key = (without_sentences(state.session), steps)
        now = frozenset(action for action in Action if offered(state, action))
        assert offers.setdefault(key, now) == now


def test_a_session_of_reworded_sentences_ends_rightly_and_its_console_offers_the_same(tmp_path: Path):
    plain: Offers = {}
    other: Offers = {}
    with contextlib.ExitStack() as stack:
        session = RewordedSession(tmp_path, stack)
        for _ in session.until_done():
            remember(session.plain, plain)
            remember(session.other, other)
        assert session.processes.stop(patience=20) == []
        places = session.follower.ending.places()
        assert places and all(p.success for p in places), places
        changed = session.relay.passed
        assert all(changed[t] for t in ("interaction/state", "interaction/prompt", "interaction/replies")), changed
        assert changed["interaction/progress"] and changed["perception/observe"] and changed["demonstration/stop"]
        shown, own = session.other.desk.state, session.plain.desk.state
        assert shown.log and shown.prompt != own.prompt
    common = plain.keys() & other.keys()
    assert {key: plain[key] for key in common} == {key: other[key] for key in common}
    # The moments at which words used to decide are among those that were compared.
    states = [state for state, _ in common]
    assert {s.phase for s in states} >= {Phase.DEMONSTRATE, Phase.ASSIST, Phase.EXECUTE}
    assert any(s.recording for s in states) and any(s.awaiting is Awaited.EXECUTION for s in states)
    assert any(Action.START in plain[key] for key in common)
    assert any(Action.START not in plain[key] for key in common if key[0].phase is Phase.DEMONSTRATE)
