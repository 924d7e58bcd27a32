"""Simulated time wakes nobody, and is right whenever it is asked for."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from mbd_model.ros.guarded_node import GuardedNode
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock

LIMIT = 20.0  # [s] bounds how long a failure takes


class Bench:
    """A node of simulated time, spun, and who states the time."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        simulated = [Parameter("use_sim_time", value=True)]
        self.node = GuardedNode("follower", context=self.context, parameter_overrides=simulated)
        self._source = Node("source", context=self.context)
        self._clock = self._source.create_publisher(Clock, "/clock", 10)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.until(lambda: self._clock.get_subscription_count() == 1)

    def state(self, seconds: int) -> None:
        """It is that time now."""
        stated = Clock()
        stated.clock.sec = seconds
        self._clock.publish(stated)

    def until(self, condition: Callable[[], bool], *, spin: bool = True) -> None:
        """Spin, or only look, until the condition holds."""
        deadline = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < deadline, "nothing came of it"
            if spin:
                self.executor.spin_once(timeout_sec=0.02)

    def seconds(self) -> int:
        """What the node takes for the time."""
        return self.node.get_clock().now().nanoseconds // 10**9


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    made = Bench(ros_domain)
    yield made
    made.executor.shutdown()
    rclpy.shutdown(context=made.context)


def test_who_asks_gets_the_time_stated_last_though_no_executor_was_woken(bench: Bench):
    bench.state(7)
    bench.until(lambda: bench.seconds() == 7, spin=False)
    for second in range(8, 40):
        bench.state(second)
    bench.until(lambda: bench.seconds() == 39, spin=False)


def test_a_timer_of_simulated_time_runs_though_nobody_asks_for_the_time(bench: Bench):
    rung: list[None] = []
    bench.node.create_timer(5.0, lambda: rung.append(None))
    bench.state(3)
    bench.until(lambda: bench.seconds() == 3)
    assert not rung
    bench.state(60)
    bench.until(lambda: bool(rung))


def test_use_sim_time_can_be_switched_off_and_on(bench: Bench):
    bench.state(5)
    bench.until(lambda: bench.seconds() == 5)
    bench.node.set_parameters([Parameter("use_sim_time", value=False)])
    assert bench.seconds() > 10**9
    bench.executor.spin_once(timeout_sec=0.3)
    bench.node.set_parameters([Parameter("use_sim_time", value=True)])
    bench.until(lambda: bool(bench.node.count_subscribers("/clock")))

    def stated() -> bool:
        bench.state(9)
        return bench.seconds() == 9

    bench.until(stated)


def test_who_subscribes_to_the_clock_as_to_any_topic_gets_it_as_any_topic(bench: Bench):
    """A recorder takes bytes and their information: asking for the time must not call it otherwise."""
    kept: list[tuple[bytes, int]] = []

    def keep(data: bytes, info: dict[str, int]) -> None:
        bench.seconds()
        kept.append((data, info["source_timestamp"]))

    bench.node.create_subscription(Clock, "/clock", keep, 10, raw=True)
    bench.until(lambda: bench.node.count_subscribers("/clock") == 2)

    def came() -> bool:
        bench.state(11)
        return bool(kept) and bench.seconds() == 11

    bench.until(came)
    assert deserialize_message(kept[-1][0], Clock).clock.sec == 11
    assert not bench.node.bad_messages.count
