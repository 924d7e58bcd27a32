"""A node that publishes to recorders, and what their bags hold of it."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from ament_index_python.packages import get_package_prefix
from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_model.ros.qos import EVENTS
from mbd_msgs.msg import WizardNote
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

PROGRAMS = Path(get_package_prefix("mbd_bag")) / "lib" / "mbd_bag"


def arguments(bag: Path, *parameters: str) -> list[str]:
    return [w for p in (f"bag:={bag}", "min_free:=1.0", *parameters) for w in ("-p", p)]


class Bench:
    """A node that publishes notes, 50 a second, numbered; and recorders started and ended."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("bench", context=self.context)
        self.node.declare_parameter("gain", 2.5)
        self.node.declare_parameter("state_dir", str(Path(__file__).parent))
        self.node.declare_parameter("camera", "/camera")
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.notes = self.node.create_publisher(WizardNote, "wizard/note", EVENTS)
        self.sent: list[float] = []
        self.node.create_timer(0.02, self._send)
        self.processes: list[subprocess.Popen[str]] = []

    def _send(self) -> None:
        self.notes.publish(WizardNote(text=str(len(self.sent))))
        self.sent.append(time.monotonic())

    def start(self, bag: Path, *parameters: str) -> subprocess.Popen[str]:
        return self.run("recorder", *arguments(bag, *parameters))

    def run(self, program: str, *words: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [str(PROGRAMS / program), "--ros-args", *words],
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.processes.append(process)
        return process

    def spin_until(self, happened: Callable[[], bool], what: str, timeout: float = 60.0) -> None:
        deadline = time.monotonic() + timeout
        while not happened():
            assert time.monotonic() < deadline, f"waited {timeout} s for {what}"
            self.executor.spin_once(timeout_sec=0.05)

    def spin_for(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def spin_until_recorded(self, topic: str = "/wizard/note", node: str = "recorder") -> None:
        """Until a recorder listens to the topic."""

        def listens() -> bool:
            return any(e.node_name == node for e in self.node.get_subscriptions_info_by_topic(topic))

        self.spin_until(listens, topic)

    def close(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.wait()
            process.stdout.close()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


def notes(path: Path) -> list[int]:
    return [int(msg.text) for _, msg in Bag(path).decoded({"/wizard/note"})]


def recorded(path: Path) -> int:
    """Notes that a file holds so far."""
    try:
        return len(notes(path))
    except BagError:
        return 0
