"""A node that is idle, and whose simulated clock stands, ends within a second of SIGINT or SIGTERM.

``MBD_STOP_SIGNALS=500 python -m pytest tests/mbd_bringup/test_ending.py`` sends so many signals instead of some fifty.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory
from forked_nodes import ForkedNode, NodeServer, node_server

MODULES = {
    "mapping": "mbd_mapping.ros.node",
    "demonstration": "mbd_demonstration.ros.node",
    "interaction": "mbd_interaction.ros.node",
    "execution": "mbd_execution.ros.node",
    "perception": "mbd_perception.ros.node",
    "recorder": "mbd_bag.ros.recorder_node",
    "spool": "mbd_bag.ros.spool_node",
    "markers": "mbd_bringup.ros.markers_node",
    "wizard": "mbd_cell.ros.wizard_node",
    "console": "mbd_console.ros.main",
    "robot": "mbd_robot.ros.robot_node",
    "camera": "mbd_robot.ros.camera_node",
}
SIGNALS = int(os.environ.get("MBD_STOP_SIGNALS", "54"))
TOGETHER = 3  # nodes that run at the same time
LATEST = 0.6  # [s] after a node began to listen, when its signal comes at the latest
LIMIT = 1.0  # [s] in which it has to end


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[NodeServer]:
    with node_server(MODULES, tmp_path_factory.mktemp("ending")) as made:
        yield made


def words_for(name: str, folder: Path, number: int) -> list[str]:
    """The command line of an idle node."""
    words = ["--ros-args", "-p", "use_sim_time:=true"]
    if name == "recorder":
        words += ["-p", f"bag:={folder / str(number)}"]
    elif name == "spool":
        words += ["-p", f"folder:={folder / str(number)}"]
    elif name == "console":
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            words += ["-p", f"port:={free.getsockname()[1]}"]
    elif name in ("robot", "camera"):
        words += ["-p", f"{name}:={'ur5e' if name == 'robot' else 'realsense'}"]
    elif name == "perception":
        words += ["--params-file", str(Path(get_package_share_directory("mbd_cell")) / "config" / "camera.yaml")]
    return words


def signal_at_random_moments(nodes: list[ForkedNode], number: int, rng: random.Random) -> None:
    """Send each node one signal, at a moment of its own after it began to listen."""
    moments: dict[ForkedNode, float] = {}
    deadline = time.monotonic() + 60.0
    left = list(nodes)
    while left:
        assert time.monotonic() < deadline, "a node set no handler for SIGINT in a minute"
        for node in list(left):
            if node not in moments and node.listens():
                moments[node] = time.monotonic() + rng.uniform(0.0, LATEST)
            if node in moments and time.monotonic() >= moments[node]:
                node.signal(number)
                left.remove(node)
        time.sleep(0.005)


@pytest.mark.alone
@pytest.mark.parametrize("ignored", [True, False], ids=["sigint_inherited_ignored", "sigint_inherited_by_default"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_one_signal_at_any_moment_ends_an_idle_node_within_a_second(number, ignored, server, ros_domain, tmp_path):
    rng = random.Random(f"{number} {ignored}")
    # SIGINT is what a session ends its nodes by: three of four signals.
    count = round(SIGNALS * (3 if number == signal.SIGINT else 1) / 8)
    names = [list(MODULES)[i % len(MODULES)] for i in range(count)]
    rng.shuffle(names)
    for first in range(0, count, TOGETHER):
        started = {
            server.start(name, words_for(name, tmp_path, first + k), ros_domain, ignored=ignored): name
            for k, name in enumerate(names[first : first + TOGETHER])
        }
        signal_at_random_moments(list(started), number, rng)
        for node, name in started.items():
            ending = node.end()
            assert ending.code == 0, f"{name}: exit code {ending.code}\n{ending.output}"
            assert "Traceback" not in ending.output, f"{name}:\n{ending.output}"
            assert ending.seconds < LIMIT, f"{name} took {ending.seconds:.2f} s\n{ending.output}"
