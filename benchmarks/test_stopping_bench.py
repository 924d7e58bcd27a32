"""How long a running session takes to end: from SIGINT to all of its nodes at once, as a launch sends it, to the last.

A simulated session with every node, the console included, is stopped once its robot speaks to the teacher.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from mbd_bag.storage.bag import Bag
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.live_session import install_prefixes
from pytest_benchmark.fixture import BenchmarkFixture

PATIENCE = 60.0  # [s] after which a node that still runs is killed, and the bench fails
BEGUN = 600.0  # [s] within which the robot speaks


def ends(processes: SessionProcesses) -> dict[str, float]:
    """Ask all nodes by one SIGINT each; when each of them ended [s]."""
    running = {os.pidfd_open(node.process.pid): node for node in processes.nodes}
    poll = select.poll()
    for descriptor in running:
        poll.register(descriptor, select.POLLIN)
    asked = time.monotonic()
    for node in processes.nodes:
        os.killpg(node.process.pid, signal.SIGINT)
    found: dict[str, float] = {}
    while len(found) < len(running) and time.monotonic() < asked + PATIENCE:
        for descriptor, _ in poll.poll(1e3):
            found[running[descriptor].name] = time.monotonic() - asked
            poll.unregister(descriptor)
    for descriptor in running:
        os.close(descriptor)
    return found


def free_port() -> int:
    """A port at which nobody listens."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@contextmanager
def running_session(folder: Path) -> Iterator[SessionProcesses]:
    """A session whose robot has said three things; afterwards its bag has to be closed and whole."""
    options = SessionOptions("stopped", folder, task="sorting", execute=True, console=True, markers=True)
    specs = session_nodes(options)
    prefixes = install_prefixes(sorted({s.package for s in specs} | {p for s in specs for p, _ in s.config if p}))
    with private_domain() as domain:
        variables = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        with SessionProcesses(prefixes, folder / "logs", variables) as processes:
            for spec in specs:
                port = {"port": free_port()} if spec.executable == "console" else {}
                processes.start(replace(spec, parameters={**spec.parameters, **port}))
            limit = time.monotonic() + BEGUN
            while processes["interaction"].log.read_text(errors="replace").count("prompt: ") < 3:
                assert time.monotonic() < limit and not processes.dead(), [n.log_tail() for n in processes.dead()]
                time.sleep(0.2)  # the pace of looking at its log
            yield processes
            assert {node.name: node.process.poll() for node in processes.nodes} == {s.executable: 0 for s in specs}
    (bag,) = {path.parent for path in folder.rglob("metadata.yaml")}
    assert not Bag(bag).problems


@pytest.mark.benchmark(group="a running session is stopped")
def test_a_running_session_ends(tmp_path: Path, benchmark: BenchmarkFixture):
    found: list[dict[str, float]] = []
    sessions: list[ExitStack] = []

    def begin() -> tuple[tuple[SessionProcesses], dict[str, object]]:
        sessions.append(ExitStack())
        return (sessions[-1].enter_context(running_session(tmp_path / str(len(sessions)))),), {}

    def end(_: SessionProcesses) -> None:
        sessions[-1].close()

    benchmark.pedantic(lambda processes: found.append(ends(processes)), setup=begin, teardown=end, rounds=3)
    for each in found:
        last = sorted(each, key=each.__getitem__)[-3:]
        print(
            f"\na session of {len(each)} nodes ended {max(each.values()):.2f} s after SIGINT; the last were "
            + ", ".join(f"{name} {each[name]:.2f} s" for name in last)
        )
    benchmark.extra_info["seconds"] = [max(each.values()) for each in found]
