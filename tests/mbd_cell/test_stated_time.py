"""The simulation's time is stated whenever it passes, and again now and then while it stands."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from mbd_cell.ros.stated_time import PERIOD, StatedTime
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

SECOND = 10**9
HOUR = 3600


@pytest.fixture
def node(ros_domain: int) -> Iterator[Node]:
    """Of simulated time."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    simulated = [Parameter("use_sim_time", value=True)]
    made = rclpy.create_node("tested", context=context, parameter_overrides=simulated)
    yield made
    made.destroy_node()
    context.try_shutdown()


def test_a_clock_that_one_message_set_ahead_is_right_again_although_time_stands(node: Node):
    time, other = StatedTime(node), node.create_publisher(Clock, "/clock", 10)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)

    def until_it_is(seconds: int) -> None:
        for _ in range(1000):
            if node.get_clock().now().nanoseconds == seconds * SECOND:
                return
            executor.spin_once(timeout_sec=0.02)
        pytest.fail(f"it is {node.get_clock().now()}")

    time.state(5 * SECOND, now=0.0)
    until_it_is(5)
    ahead = Clock()
    ahead.clock.sec = HOUR
    other.publish(ahead)
    until_it_is(HOUR)
    time.state(5 * SECOND, now=PERIOD / 2.0)  # not due yet
    executor.spin_once(timeout_sec=0.1)
    assert node.get_clock().now().nanoseconds == HOUR * SECOND
    time.state(5 * SECOND, now=PERIOD)
    until_it_is(5)
    time.state(6 * SECOND, now=PERIOD)  # it passes
    until_it_is(6)
