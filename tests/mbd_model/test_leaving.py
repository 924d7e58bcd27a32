"""A node that ends is gone for the others at once; its process ends as any, but for the search for garbage."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from mbd_model.ros.run_node import run_node
from mbd_msgs.action import MoveTool
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import Executor
from rclpy.node import Node
from std_msgs.msg import Header
from std_srvs.srv import Trigger

LEASE = 20.0  # [s] after which Fast DDS takes a participant for lost that says nothing any more, not even farewell


@pytest.fixture
def watcher(ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[Node]:
    """Another node, of a context of its own; and this process as that of a node."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(ros_domain))
    monkeypatch.setattr(sys, "argv", ["tested"])
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("watcher", context=context)
    yield node
    node.destroy_node()
    context.try_shutdown()
    for number, handler in handlers.items():
        signal.signal(number, handler)


def wait_until(watcher: Node, *, there: bool, seconds: float) -> None:
    """Until the node tested is there, or not."""
    limit = time.monotonic() + seconds
    while ("tested" in watcher.get_node_names()) is not there:
        assert time.monotonic() < limit
        time.sleep(0.01)  # the pace of looking


def test_a_node_with_all_that_a_node_may_have_is_gone_for_the_others_before_its_lease_ends(watcher: Node):
    kept: list[object] = []  # alive all the same, as what is in a cycle is

    def make() -> Node:
        node = Node("tested")
        kept.extend([
            node,
            node.create_publisher(Header, "said", 1),
            node.create_subscription(Header, "said", print, 1),
            node.create_service(Trigger, "asked", lambda _, answer: answer),
            node.create_client(Trigger, "asked"),
            node.create_timer(0.01, lambda: None),
            ActionClient(node, MoveTool, "moved"),
            ActionServer(node, MoveTool, "moved", lambda goal: MoveTool.Result()),
        ])  # fmt: skip
        return node

    def spin(executor: Executor, node: Node) -> None:
        wait_until(watcher, there=True, seconds=60.0)

    run_node("tested", make, spin)
    wait_until(watcher, there=False, seconds=LEASE / 2.0)


ENDING = """
import atexit, sys, tempfile, weakref
from mbd_model.ros.run_node import run_node
from rclpy.node import Node

class Cycle:
    def __init__(self):
        self.own = self
    def __del__(self):
        print("garbage was searched")

folder = tempfile.TemporaryDirectory()
atexit.register(print, "ended")
sys.modules["kept"] = Cycle()
print(folder.name)
run_node("living", lambda: Node("living"), lambda executor, node: None)
sys.exit(3)
"""


def test_a_process_ends_with_its_code_and_what_it_has_to_do_at_its_end_and_searches_no_garbage(ros_domain, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(ros_domain))
    ended = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, timeout=120, check=False)
    folder, *rest = ended.stdout.splitlines()
    assert (ended.returncode, rest, ended.stderr) == (3, ["ended"], "")
    assert not Path(folder).exists()
