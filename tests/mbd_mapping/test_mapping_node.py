"""The mapping node as a process of its own, over real messages."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.synthetic import random_scene
from mbd_model.assists import Assist
from mbd_model.conversions import assists_to_msg, estimate_from_msg, scene_to_msg, task_to_msg
from mbd_model.objects import Role
from mbd_model.qos import LATCHED
from mbd_model.task import StepKind, Task, TaskStep
from mbd_msgs import msg as m
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

rng = np.random.default_rng(3)
SOURCE, TARGET = random_scene(rng, Role.SOURCE, 5, "s"), random_scene(rng, Role.TARGET, 5, "t")
TASK = Task(SOURCE, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(SOURCE.ids)), stamp=1.0)


class Bench:
    """A mapping node in a process, and this process's publishers and subscribers around it."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.process: subprocess.Popen[str] | None = None
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("bench", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.estimates: list[m.MappingEstimate] = []
        self.diagnostics: list[DiagnosticStatus] = []
        self.task = self.node.create_publisher(m.Task, "demonstration/task", LATCHED)
        self.target = self.node.create_publisher(m.Scene, "perception/target_scene", LATCHED)
        self.assists = self.node.create_publisher(m.Assists, "interaction/assists", LATCHED)
        self.node.create_subscription(m.MappingEstimate, "mapping/estimate", self.estimates.append, LATCHED)
        self.node.create_subscription(DiagnosticArray, "diagnostics", lambda a: self.diagnostics.extend(a.status), 10)
        self.parameters = self.node.create_client(SetParameters, "mapping/set_parameters")

    def start(self, *parameters: str) -> None:
        """Start the node."""
        flags = [word for p in parameters for word in ("-p", p)]
        command = [sys.executable, "-m", "mbd_mapping.node", "--ros-args", *flags]
        self.process = subprocess.Popen(command, env=self.environment, stderr=subprocess.PIPE, text=True)

    def until(self, what: Callable[[], bool], timeout: float = 20.0) -> None:
        """Spin until something holds."""
        end = time.monotonic() + timeout
        while not what():
            assert time.monotonic() < end, "it did not happen in time"
            self.executor.spin_once(timeout_sec=0.1)

    def give(self, assists: list[Assist], stamp: float) -> None:
        """Publish task, scene and assists."""
        self.task.publish(task_to_msg(TASK))
        self.target.publish(scene_to_msg(TARGET))
        self.assists.publish(assists_to_msg(tuple(assists), stamp, "trial"))

    def estimate_of(self, stamp: int) -> m.MappingEstimate:
        """Wait for the estimate made from the assists of that time."""
        self.until(lambda: bool(self.estimates) and self.estimates[-1].assists_stamp.sec == stamp)
        return self.estimates[-1]

    def set_threshold(self, value: float) -> SetParameters.Response:
        """Change the parameter while the node runs."""
        assert self.parameters.wait_for_service(20.0)
        request = SetParameters.Request(parameters=[Parameter("threshold", value=value).to_parameter_msg()])
        future = self.parameters.call_async(request)
        self.until(future.done)
        return future.result()

    def stop(self, how: signal.Signals = signal.SIGINT) -> int:
        """End the node; returns its exit code."""
        assert self.process is not None
        self.process.send_signal(how)
        self.process.communicate(timeout=20.0)
        return self.process.returncode

    def close(self) -> None:
        """End everything."""
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.communicate()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    """A domain of its own."""
    made = Bench(ros_domain)
    yield made
    made.close()


def test_the_estimate_is_that_of_the_function(bench: Bench) -> None:
    """What the node publishes is what ``infer`` returns for the same inputs, with their stamps."""
    bench.start("threshold:=0.5")
    assists = [Assist("s0", "t3"), Assist("s1", "t0", 1)]
    bench.give(assists, 7.0)
    msg = bench.estimate_of(7)
    expected = infer(TASK, TARGET, assists, MappingConfig())
    assert estimate_from_msg(msg) == expected
    assert msg.threshold == 0.5
    assert msg.confident == (expected.confidence >= 0.5)
    assert (msg.session, msg.task_stamp.sec, msg.header.stamp.sec) == ("trial", 1, 7)
    assert bench.stop() == 0


def test_an_undo_leaves_no_trace(bench: Bench) -> None:
    """A shorter list gives the estimate there was before the longer one."""
    bench.start()
    bench.give([], 5.0)
    before = estimate_from_msg(bench.estimate_of(5))
    bench.give([Assist("s0", "t3")], 6.0)
    bench.estimate_of(6)
    bench.give([], 7.0)
    assert estimate_from_msg(bench.estimate_of(7)) == before


def test_a_killed_node_says_the_same_again(bench: Bench) -> None:
    """Killed and started again, the node gets its inputs again and publishes the same estimate."""
    bench.start()
    bench.give([Assist("s0", "t3")], 5.0)
    before = bench.estimate_of(5)
    bench.stop(signal.SIGKILL)
    bench.estimates.clear()
    bench.start()
    assert bench.estimate_of(5) == before


def test_the_threshold_may_change_while_running(bench: Bench) -> None:
    """A new threshold is published with the same estimate; one out of range is refused and changes nothing."""
    bench.start()
    bench.give([], 5.0)
    bench.estimate_of(5)
    assert bench.set_threshold(0.9).results[0].successful
    bench.until(lambda: bench.estimates[-1].threshold == 0.9)
    refused = bench.set_threshold(1.5).results[0]
    assert not refused.successful
    assert "1.5" in refused.reason or "range" in refused.reason
    assert bench.set_threshold(float("nan")).results[0].successful is False
    assert bench.estimates[-1].threshold == 0.9


def test_what_cannot_be_used_is_reported(bench: Bench) -> None:
    """An unknown id stands on the estimate and on diagnostics; a scene of the wrong role is refused there."""
    bench.start()
    bench.give([Assist("ghost", "t0")], 5.0)
    assert "ghost" in bench.estimate_of(5).warnings[0]
    bench.until(lambda: any(d.level == DiagnosticStatus.WARN and "ghost" in d.message for d in bench.diagnostics))
    bench.target.publish(scene_to_msg(SOURCE))
    bench.until(lambda: any(d.level == DiagnosticStatus.ERROR and "target" in d.message for d in bench.diagnostics))


def test_an_unknown_strategy_stops_the_node_with_a_reason(bench: Bench) -> None:
    """The node ends with code 1 and names the strategies there are."""
    bench.start("strategy:=psychic")
    assert bench.process is not None
    error = bench.process.communicate(timeout=20.0)[1]
    assert bench.process.returncode == 1
    assert "psychic" in error
    assert "mbd" in error
