"""The processes of a session start, die and end as the demo needs."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest
import rclpy
from ament_index_python.packages import get_package_share_directory
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import NodeSpec, SessionOptions, session_nodes
from mbd_bringup.processes import Deaths, SessionProcesses
from mbd_bringup.transport import OWN_SOCKETS, RANGE, SHARED_MEMORY, SOCKETS, VARIABLE, profile_variables
from mbd_model.errors import MbdError
from rclpy.node import Node

pytestmark = pytest.mark.node

STUBBORN = "trap '' INT USR1; echo ready; while :; do read -r -t 0.05 < /dev/zero || :; done"


def install(prefix: Path, name: str, script: str) -> NodeSpec:
    """A shell script in the place of an installed executable."""
    file = prefix / "lib" / "pkg" / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"#!/bin/bash\n{script}\n")
    file.chmod(0o755)
    return NodeSpec("pkg", name)


def wait_for(log: Path, text: str, seconds: float = 20.0) -> None:
    """Until the log holds the text; fails when it never does."""
    end = time.monotonic() + seconds
    while text not in log.read_text():
        assert time.monotonic() < end, f"{log} never showed {text!r}: {log.read_text()!r}"
        time.sleep(0.01)


def test_a_node_ends_on_sigint_and_its_output_is_in_its_log(tmp_path):
    spec = install(tmp_path, "good", "trap 'echo closed; exit 0' INT; echo ready; while :; do sleep 0.05; done")
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        node = processes.start(spec)
        wait_for(node.log, "ready")
        assert processes.stop() == []
    assert "closed" in node.log.read_text()


def test_a_node_that_ignores_sigint_is_killed_and_named(tmp_path):
    spec = install(tmp_path, "stubborn", STUBBORN)
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        node = processes.start(spec)
        wait_for(node.log, "ready")
        assert processes.stop(patience=0.3) == ["stubborn"]
    assert node.process.returncode == -signal.SIGKILL


def test_a_node_that_took_no_notice_of_the_first_sigint_is_asked_again(tmp_path):
    second = "n=0; trap 'n=$((n + 1)); [ $n -lt 2 ] || { echo closed; exit 0; }' INT"
    spec = install(tmp_path, "deaf", f"{second}; echo ready; while :; do sleep 0.05; done")
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        node = processes.start(spec)
        wait_for(node.log, "ready")
        assert processes.stop(patience=20.0) == []
    assert "closed" in node.log.read_text()


def test_the_node_started_first_ends_last_also_after_it_was_started_again(tmp_path):
    ended = tmp_path / "ended"
    script = "trap 'echo $(basename $0) >> {}; exit 0' INT; echo ready; while :; do sleep 0.02; done"
    specs = [install(tmp_path, name, script.format(ended)) for name in ("first", "second", "third")]
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        for spec in specs:
            wait_for(processes.start(spec).log, "ready")
        (tmp_path / "logs" / "first.log").write_text("")
        wait_for(processes.restart("first").log, "ready")
        assert [n.name for n in processes.nodes] == ["first", "second", "third"]
        assert processes.stop() == []
    assert ended.read_text().split()[-1] == "first"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_started_by_who_ignores_a_signal_takes_it_as_by_default(number, tmp_path):
    spec = install(tmp_path, "node", "grep SigIgn /proc/$$/status; exec sleep 60")
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
            node = processes.start(spec)
            wait_for(node.log, "\n")
            ignored = int(node.log.read_text().split()[1], 16)
    finally:
        signal.signal(number, before)
    assert not ignored >> (number - 1) & 1


@pytest.mark.parametrize(
    ("shared", "reach", "profile"),
    [
        (True, "LOCALHOST", "fastdds_profile.xml"),
        (False, "LOCALHOST", "fastdds_local_profile.xml"),
        (False, "SUBNET", "fastdds_small_profile.xml"),
    ],
)
def test_only_nodes_that_must_share_memory_unless_the_user_chose_a_profile(shared, reach, profile, tmp_path):
    spec = replace(install(tmp_path, "node", 'echo "$FASTRTPS_DEFAULT_PROFILES_FILE"'), shared_memory=shared)
    for chosen, taken in (("/any/fastdds_profile.xml", f"/any/{profile}"), ("/my/own.xml", "/my/own.xml")):
        environment = {VARIABLE: chosen, RANGE: reach}
        with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", environment) as processes:
            wait_for(processes.start(spec).log, f"{taken}\n")


def test_the_profiles_lie_side_by_side_and_name_no_other_difference_than_shared_memory():
    shared, sockets, own = (
        ET.parse(Path(get_package_share_directory("mbd_bringup")) / "config" / name)
        for name in (SHARED_MEMORY, SOCKETS, OWN_SOCKETS)
    )
    transports = [[t.text for t in tree.iter() if t.tag.endswith("}type")] for tree in (shared, sockets, own)]
    assert transports == [["SHM", "UDPv4"], ["UDPv4"], ["UDPv4"]]
    assert [t.text for t in own.iter() if t.tag.endswith("}address")] == ["127.0.0.1"]


# What a process has of Fast DDS, looked at from outside: the names of its threads, and where its sockets are.
TRANSPORTS = """
import os, pathlib, rclpy
rclpy.init()
node = rclpy.create_node("looked_at")
threads = [p.read_text().strip() for p in pathlib.Path("/proc/self/task").glob("*/comm")]
links = [os.path.realpath(p) for p in pathlib.Path("/proc/self/fd").iterdir()]
mine = {link.partition("socket:[")[2][:-1] for link in links if "socket:" in link}
rows = [line.split() for line in pathlib.Path("/proc/self/net/udp").read_text().splitlines()[1:]]
print(sum(".shm." in name for name in threads), sorted({row[1][:8] for row in rows if row[9] in mine}), flush=True)
os._exit(0)
"""


@pytest.mark.parametrize("shared", [True, False])
def test_a_node_of_a_session_on_this_machine_alone_has_no_shared_memory_unless_it_must(shared: bool, tmp_path: Path):
    """With LOCALHOST alone rmw adds shared memory to any profile; a killed node then stops others for good."""
    profile = Path(get_package_share_directory("mbd_bringup")) / "config" / SHARED_MEMORY
    environment = {**os.environ, VARIABLE: str(profile), RANGE: "LOCALHOST"}
    with private_domain() as domain:
        environment |= {"ROS_DOMAIN_ID": str(domain), **profile_variables(environment, shared_memory=shared)}
        done = subprocess.run(
            [sys.executable, "-c", TRANSPORTS], env=environment, capture_output=True, text=True, check=True
        )
    number, _, addresses = done.stdout.partition(" ")
    assert (int(number) > 0) == shared, done.stdout
    if not shared:
        assert set(ast.literal_eval(addresses)) <= {"0100007F", "0100FFEF"}, done.stdout


def test_a_node_that_ended_by_itself_is_reported(tmp_path):
    spec = install(tmp_path, "short", "echo last words; exit 3")
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        node = processes.start(spec)
        node.process.wait(20)
        assert [n.name for n in processes.dead()] == ["short"]
        assert node.log_tail() == "last words"


def test_a_restarted_node_is_another_process_with_the_same_log(tmp_path):
    spec = install(tmp_path, "good", "echo ready $$; exec sleep 60")
    with SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes:
        first = processes.start(spec)
        wait_for(first.log, "ready")
        second = processes.restart("good")
        wait_for(second.log, f"ready {second.process.pid}")
        assert first.process.returncode == -signal.SIGKILL
        assert processes.dead() == []


def test_nodes_end_when_their_parent_is_killed(tmp_path):
    spec = install(tmp_path, "good", "trap 'echo closed; exit 0' INT; echo ready; while :; do sleep 0.05; done")
    child = os.fork()
    if child == 0:
        processes = SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {})
        processes.__enter__()
        node = processes.start(spec)
        wait_for(node.log, "ready")
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    wait_for(tmp_path / "logs" / "good.log", "closed")


def test_an_executable_that_is_not_installed_is_named_with_what_to_do(tmp_path):
    with (
        SessionProcesses({"pkg": tmp_path}, tmp_path / "logs", {}) as processes,
        pytest.raises(MbdError, match=r"no executable 'nothing'.*make build"),
    ):
        processes.start(NodeSpec("pkg", "nothing"))


# Many texts to a node: starting it is what takes time.
@settings(max_examples=3)
@example(["", "07", "1e5", "0x1f", "null", "on", "it's: #1, 'quoted'", "~/sessions", "[a]"])
@given(st.lists(st.text(st.characters(min_codepoint=32, max_codepoint=126)), min_size=20, max_size=40))
def test_a_node_reads_the_very_parameters_it_was_given(texts):
    given_parameters = {f"text{i}": t for i, t in enumerate(texts)} | {"small": 1e-7, "complete": 7, "wanted": True}
    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    with tempfile.TemporaryDirectory() as folder:
        spec = replace(install(Path(folder), "node", ""), parameters=given_parameters)
        words = SessionProcesses({"pkg": Path(folder)}, Path(folder), {}).command(spec)
    node = Node("reader", context=context, cli_args=list(words[words.index("--ros-args") :]))
    try:
        read = {n: node.declare_parameter(n, v).value for n, v in given_parameters.items()}
    finally:
        node.destroy_node()
        context.shutdown()
    assert read == given_parameters


def test_the_session_without_simulation_starts_no_cell(tmp_path):
    real = session_nodes(SessionOptions("s", tmp_path, simulated=False))
    simulated = session_nodes(SessionOptions("s", tmp_path))
    assert {n.package for n in simulated} - {n.package for n in real} == {"mbd_cell"}
    assert all(n.parameters["use_sim_time"] is False for n in real)
    assert simulated[0].executable == "recorder"


def test_a_node_that_does_not_come_up_is_given_up_and_one_that_is_killed_however_often_is_not():
    deaths = Deaths()
    assert not any(
        deaths.gives_up("cell", code, age) for code, age in [(-9, 0.1)] * 9 + [(0, 0.1)] * 9 + [(1, 60.0)] * 9
    )
    assert [deaths.gives_up("wizard", 1, 0.5) for _ in range(3)] == [False, False, True]
    assert not deaths.gives_up("mapping", 1, 0.5)


def test_two_domains_held_at_once_differ():
    with private_domain() as one, private_domain() as other:
        assert one != other


@pytest.mark.parametrize(("camera", "shares"), [("", False), ("zed", False), ("azure_kinect", False), ("orbbec", True)])
def test_no_node_of_the_cell_shares_memory_unless_its_camera_sends_nothing_again(camera, shares, tmp_path):
    """Who shares memory with a killed process may stand still for ever."""
    nodes = session_nodes(SessionOptions("s", tmp_path, camera=camera, console=True))
    assert any(node.shared_memory for node in nodes) == shares
    real = session_nodes(SessionOptions("s", tmp_path, simulated=False))
    assert {n.executable for n in real if n.shared_memory} == {"recorder", "perception"}
