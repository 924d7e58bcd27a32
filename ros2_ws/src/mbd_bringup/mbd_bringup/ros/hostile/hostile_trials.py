"""``hostile_messages``: a session's nodes as real processes, each sent what nobody would send; counts how many die."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import rclpy
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from mbd_model.errors import MbdError
from rcl_interfaces.srv import ListParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rich.console import Console

from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.hostile.hostile_sender import HostileSender
from mbd_bringup.ros.live_session import install_prefixes

_START, _ANSWER = 600.0, 600.0  # [s] within which nodes are there, and answer afterwards
_QUIET = 0.2  # [s] to listen between rounds


@dataclass(frozen=True)
class HostileResult:
    """What became of a session's nodes.

    Attributes:
        sent: messages and requests, by topic or service.
        deaths: how often each node ended.
        last_words: of those, the end of each log.
        silent: nodes that did not answer afterwards.
    """

    sent: dict[str, int]
    deaths: dict[str, int]
    last_words: tuple[str, ...]
    silent: tuple[str, ...]


def hostile_trial(
    number: int,
    seed: int,
    folder: Path,
    *,
    robot: str = "",
    camera: str = "",
    leave_out: frozenset[str] = frozenset(),
) -> HostileResult:
    """Start a session's nodes, send so many hostile messages, and see who is still there.

    Args:
        number: of messages and requests.
        seed: of what they hold.
        folder: for bag, state and logs.
        robot: profile whose nodes are started, too; the cell plays the driver. "" for none.
        camera: alike.
        leave_out: executables not to start.

    Raises:
        MbdError: the nodes did not come up.
    """
    options = SessionOptions(
        "hostile", folder, execute=True, console=True, markers=True, scripted_wizard=False, robot=robot, camera=camera
    )
    specs = [s for s in session_nodes(options) if s.executable not in leave_out]
    packages = {s.package for s in specs} | {package for s in specs for package, _ in s.config if package}
    prefixes = install_prefixes(sorted(packages))
    with private_domain() as domain:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        node = Node("hostile_sender", context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        try:
            variables = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
            with SessionProcesses(prefixes, folder / "logs", variables) as processes:
                for spec in specs:
                    processes.start(spec)
                names = {spec.executable for spec in specs}
                _wait_for(names, node, executor, processes)
                return _send_all(number, HostileSender(node, np.random.default_rng(seed)), names, executor, processes)
        finally:
            executor.shutdown()
            node.destroy_node()
            rclpy.try_shutdown(context=context)


def _wait_for(names: set[str], node: Node, executor: SingleThreadedExecutor, processes: SessionProcesses) -> None:
    deadline = time.monotonic() + _START
    while missing := names - set(node.get_node_names()):
        if time.monotonic() > deadline or processes.dead():
            words = "; ".join(n.log_tail(3) for n in processes.dead())
            raise MbdError(f"nodes {sorted(missing)} did not come up within {_START:g} s. {words}")
        executor.spin_once(timeout_sec=0.2)


def _send_all(
    number: int, sender: HostileSender, names: set[str], executor: SingleThreadedExecutor, processes: SessionProcesses
) -> HostileResult:
    deaths: Counter[str] = Counter()
    words: list[str] = []
    sender.look(names)
    for _ in sender.rounds(number):
        end = time.monotonic() + _QUIET
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.05)
        for dead in processes.dead():
            deaths[dead.name] += 1
            words.append(f"{dead.name}: {dead.log_tail(6)}")
            processes.start(dead.spec)
        sender.look(names)
    silent = tuple(name for name in sorted(names) if not _answers(name, sender.node, executor))
    for dead in processes.dead():
        deaths[dead.name] += 1
        words.append(f"{dead.name}: {dead.log_tail(6)}")
    return HostileResult(dict(sender.sent), dict(deaths), tuple(words), silent)


def _answers(name: str, node: Node, executor: SingleThreadedExecutor) -> bool:
    client = node.create_client(ListParameters, f"/{name}/list_parameters")
    deadline = time.monotonic() + _ANSWER
    while not client.service_is_ready() and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.1)
    answer = client.call_async(ListParameters.Request())
    while not answer.done() and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.1)
    return bool(answer.done())


def main() -> None:
    """Entry point: exit code 0 when no node died and all still answer, 1 otherwise."""
    parser = CommandParser(prog="hostile_messages", description=__doc__)
    parser.add_argument(
        "--number", type=at_least_one, default=20_000, help="messages and requests to send (default 20000)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of what they hold (default 1)")
    parser.add_argument("--robot", default="", help="profile of a robot whose nodes are tried, too (default: none)")
    parser.add_argument("--camera", default="", help="profile of a camera, alike")
    parser.add_argument("--leave-out", nargs="*", default=[], metavar="NODE", help="nodes not to start")
    arguments = parser.parse_args()
    console = Console()
    with TemporaryDirectory(prefix="mbd_hostile_") as folder:
        result = hostile_trial(
            arguments.number,
            arguments.seed,
            Path(folder),
            robot=arguments.robot,
            camera=arguments.camera,
            leave_out=frozenset(arguments.leave_out),
        )
    for words in result.last_words:
        console.print(words, highlight=False, soft_wrap=True, markup=False)
    console.print(
        f"{sum(result.sent.values())} messages and requests to {len(result.sent)} topics and services: "
        f"{sum(result.deaths.values())} deaths{' ' + str(result.deaths) if result.deaths else ''}; "
        f"{len(result.silent)} nodes without an answer afterwards{' ' + str(result.silent) if result.silent else ''}",
        highlight=False,
        soft_wrap=True,
        markup=False,
    )
    raise SystemExit(1 if result.deaths or result.silent else 0)
