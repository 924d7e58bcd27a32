"""A node waits for this machine's own address before it joins the others, and says when it does not come."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from mbd_model.ros.starting.loopback import wait_for_loopback

WAITING = "from mbd_model.ros.starting.loopback import wait_for_loopback; wait_for_loopback({})"


# Its device goes away and comes back while the node is made, the first time.
JOINING = """
import subprocess, sys
from pathlib import Path
from rclpy.node import Node
from mbd_model.ros.run_node import run_node
made = Path(sys.argv.pop())
def lo(state):
    subprocess.run(["ip", "link", "set", "lo", state], check=True)
def make():
    first = not made.exists()
    made.touch()
    if first:
        lo("down")
    node = Node("joining")
    if first:
        lo("up")
    node.get_logger().info(f"made, the first time: {first}")
    return node
run_node("joining", make, lambda executor, node: node.get_logger().info("spins"))
"""


def in_a_network_of_its_own(script: str, program: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a program in a new network namespace, whose loopback device is down, while a shell does something there."""
    command = ["unshare", "-n", "sh", "-c", script, "sh", sys.executable, "-c", program, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "unshare failed" in done.stderr:
        pytest.skip("no network namespace can be made here: that takes root")
    return done


def test_where_the_address_is_there_nothing_is_waited_for():
    wait_for_loopback(0.0)


def test_a_loopback_device_that_comes_up_is_waited_for():
    done = in_a_network_of_its_own('"$@" & ip link set lo up; wait $!', WAITING.format(60.0))
    assert done.returncode == 0, done.stderr


def test_one_that_stays_down_is_named_with_what_to_do():
    done = in_a_network_of_its_own('"$@"', WAITING.format(0.1))
    assert done.returncode == 1
    assert "127.0.0.1 is not there (Network is unreachable): bring the loopback device up" in done.stderr


def test_a_node_that_joined_while_the_device_was_away_joins_once_more(tmp_path: Path):
    done = in_a_network_of_its_own('ip link set lo up; exec "$@"', JOINING, str(tmp_path / "made"))
    assert done.returncode == 0, done.stderr
    told = [line.partition("[joining]: ")[2] for line in done.stderr.splitlines() if "[joining]" in line]
    assert told == [
        "made, the first time: True",
        "the network of this machine was away while this node joined it: once more",
        "made, the first time: False",
        "spins",
    ]
