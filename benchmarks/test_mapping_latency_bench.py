"""Assist published to estimate received between two processes, beside an empty round trip of the same run."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import rclpy
from mbd_bringup.domain import private_domain
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist
from mbd_model.objects import Role
from mbd_model.ros.conversions import assists_to_msg, scene_to_msg, task_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_model.task import StepKind, Task, TaskStep
from mbd_msgs import msg as m
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Header

ROUNDS = 300
ECHO = """
import rclpy
from mbd_model.ros.qos import LATCHED
from std_msgs.msg import Header
rclpy.init()
node = rclpy.create_node('echo')
publisher = node.create_publisher(Header, 'pong', LATCHED)
node.create_subscription(Header, 'ping', publisher.publish, LATCHED)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """A ROS domain of its own."""
    with private_domain() as domain:
        yield domain


@pytest.fixture
def processes(ros_domain: int) -> Iterator[list[subprocess.Popen[bytes]]]:
    """The mapping node of either strategy and an echo, each a process."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    commands = [[sys.executable, "-c", ECHO]]
    for strategy in ("mbd", "evidence"):
        names = ["-r", f"mapping/estimate:={strategy}/estimate", "-r", f"__node:={strategy}"]
        node = [sys.executable, "-m", "mbd_mapping.ros.node", "--ros-args", "-p", f"strategy:={strategy}", *names]
        commands.append(node)
    started = [subprocess.Popen(command, env=environment) for command in commands]
    yield started
    for process in started:
        process.terminate()
    for process in started:
        process.wait(timeout=20)


class Timer:
    """Publishes, waits for the answer and measures."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("timer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.answer: object = None

    def on_message(self, msg: object) -> None:
        """Keep the last answer."""
        self.answer = msg

    def wait(self, is_answer: Callable[[object], bool], timeout: float = 30.0) -> None:
        """Spin until it is there."""
        end = time.monotonic() + timeout
        while self.answer is None or not is_answer(self.answer):
            assert time.monotonic() < end, "no answer"
            self.executor.spin_once(timeout_sec=1.0)

    def times(self, publish: Callable[[int], None], is_answer: Callable[[object, int], bool]) -> np.ndarray:
        """Milliseconds of each round; the first ones, of discovery, are not counted."""
        found = []
        for k in range(1, ROUNDS + 21):
            begun = time.perf_counter()
            publish(k)
            self.wait(lambda answer, k=k: is_answer(answer, k))
            found.append(1e3 * (time.perf_counter() - begun))
        return np.array(found[20:])

    def close(self) -> None:
        """End."""
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


def test_latency(
    benchmark: Callable[..., object],
    ros_domain: int,
    processes: list[subprocess.Popen[bytes]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """From assist to estimate, seven objects, p50 and p99 beside the empty round trip."""
    rng = np.random.default_rng(1)
    source, target = random_scene(rng, Role.SOURCE, 7, "s"), random_scene(rng, Role.TARGET, 7, "t")
    task = Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)))
    timer = Timer(ros_domain)
    ping = timer.node.create_publisher(Header, "ping", LATCHED)
    assists = timer.node.create_publisher(m.Assists, "interaction/assists", LATCHED)
    tasks = timer.node.create_publisher(m.Task, "demonstration/task", LATCHED)
    scenes = timer.node.create_publisher(m.Scene, "perception/target_scene", LATCHED)
    rows = {}
    try:
        pong = timer.node.create_subscription(Header, "pong", timer.on_message, LATCHED)
        rows["empty round trip"] = timer.times(
            lambda k: ping.publish(Header(frame_id=str(k))), lambda answer, k: answer.frame_id == str(k)
        )
        timer.node.destroy_subscription(pong)
        tasks.publish(task_to_msg(task))
        scenes.publish(scene_to_msg(target))

        def give(k: int) -> None:
            chosen = (Assist(f"s{k % 7}", f"t{k % 5}"), Assist(f"s{(k + 1) % 7}", "t6"))
            assists.publish(assists_to_msg(chosen, float(k + offset), "bench"))

        for offset, strategy in ((0, "mbd"), (1000, "evidence")):
            timer.answer = None
            listening = timer.node.create_subscription(
                m.MappingEstimate, f"{strategy}/estimate", timer.on_message, LATCHED
            )
            rows[f"assist to estimate, {strategy}"] = timer.times(
                give, lambda answer, k, offset=offset: answer.assists_stamp.sec == k + offset
            )
            timer.node.destroy_subscription(listening)
    finally:
        timer.close()
    lines = [
        "",
        f"{'between two processes, n = 7':36} {'p50':>9} {'p99':>9}   ({ROUNDS} rounds, both strategies running)",
    ]
    for name, times in rows.items():
        p50, p99 = np.percentile(times, [50, 99])
        lines.append(f"{name:36} {p50:6.2f} ms {p99:6.2f} ms")
        benchmark.extra_info[name] = {"p50_ms": p50, "p99_ms": p99}
    with capsys.disabled():
        sys.stdout.write("\n".join(lines) + "\n")
    benchmark.pedantic(lambda: None, rounds=1)
    assert np.percentile(rows["assist to estimate, mbd"], 50) < 100.0
