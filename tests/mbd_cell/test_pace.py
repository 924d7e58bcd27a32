"""Simulated time waits for the node that reads the driver, and not for one that is not there."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from mbd_cell.ros.stand_in import pace as module
from mbd_cell.ros.stand_in.pace import LEAD_NS, Pace
from mbd_model.ros.conversions import stamp_to_msg
from mbd_model.ros.qos import SENSOR
from mbd_robot.topics import JOINT_STATE
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState

SECOND = 10**9


class Passing:
    """A cell's pace, and the robot node's publisher."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, args=[], domain_id=domain)
        self.node = Node("cell", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.pace = Pace(self.node)
        self.out = self.node.create_publisher(JointState, JOINT_STATE, SENSOR)

    def pass_on(self, time_ns: int) -> None:
        """The robot node has read the driver up to then; returns when the cell knows."""
        msg = JointState()
        msg.header.stamp = stamp_to_msg(time_ns)
        for _ in range(600):
            self.out.publish(msg)
            self.executor.spin_once(timeout_sec=0.1)
            if not self.pace.ahead(time_ns) and self.pace.ahead(time_ns + LEAD_NS + 1):
                return
        pytest.fail("what was passed on was not received")


@pytest.fixture
def passing(ros_domain: int) -> Iterator[Passing]:
    made = Passing(ros_domain)
    yield made
    made.node.destroy_node()
    rclpy.try_shutdown(context=made.context)


def test_time_passes_freely_until_somebody_passes_the_driver_on(passing: Passing):
    assert not passing.pace.ahead(100 * SECOND)


def test_time_stands_when_it_is_ahead_and_goes_on_when_the_other_has_caught_up(
    passing: Passing, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, "PATIENCE", 1e9)
    passing.pass_on(SECOND)
    assert not passing.pace.ahead(SECOND + LEAD_NS)
    assert passing.pace.ahead(SECOND + LEAD_NS + 1)
    passing.pass_on(2 * SECOND)
    assert not passing.pace.ahead(2 * SECOND + LEAD_NS)


def test_a_node_that_is_gone_is_not_waited_for(passing: Passing, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "PATIENCE", 1e9)
    passing.pass_on(SECOND)
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    assert not passing.pace.ahead(100 * SECOND)
