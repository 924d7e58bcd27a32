"""A service call ends, whether its answer comes or not."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from mbd_model.ros.patient_call import call_within
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

PATIENCE = 0.3


class Pair:
    """A caller whose simulated clock stands, and a server whose answers the test gives by hand."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        clock = Parameter("use_sim_time", value=True)
        self.caller = Node("caller", context=self.context, parameter_overrides=[clock])
        self.client = self.caller.create_client(Trigger, "serve")
        self.answers: list[Trigger.Response | None] = []
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.caller)

    def serve(self) -> None:
        server = Node("server", context=self.context)
        server.create_service(Trigger, "serve", lambda _, response: Trigger.Response(success=True, message="here"))
        self._executor.add_node(server)

    def call(self) -> None:
        call_within(self.caller, self.client, Trigger.Request(), PATIENCE, self.answers.append)

    def spin_until(self, happened: Callable[[], bool], seconds: float = 20.0) -> bool:
        end = time.monotonic() + seconds
        while not happened() and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)
        return happened()

    def close(self) -> None:
        for node in self._executor.get_nodes():
            node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def pair(ros_domain: int) -> Iterator[Pair]:
    pair = Pair(ros_domain)
    yield pair
    pair.close()


def test_an_answer_in_time_is_given_once_and_nothing_is_left_running(pair):
    pair.serve()
    assert pair.spin_until(pair.client.service_is_ready)
    timers = len(list(pair.caller.timers))
    pair.call()
    assert pair.spin_until(lambda: bool(pair.answers))
    assert not pair.spin_until(lambda: len(pair.answers) > 1, 2.0 * PATIENCE)
    assert [answer.message for answer in pair.answers] == ["here"]
    assert len(list(pair.caller.timers)) == timers


def test_without_an_answer_it_ends_although_simulated_time_stands(pair):
    pair.call()
    assert pair.spin_until(lambda: bool(pair.answers))
    assert pair.answers == [None]
    assert not pair.spin_until(lambda: len(pair.answers) > 1, 2.0 * PATIENCE)


def test_an_answer_that_comes_too_late_is_dropped(pair):
    pair.call()
    assert pair.spin_until(lambda: bool(pair.answers))
    pair.serve()
    assert pair.spin_until(pair.client.service_is_ready)
    assert not pair.spin_until(lambda: len(pair.answers) > 1, 2.0 * PATIENCE)
