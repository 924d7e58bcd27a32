"""A stop holds until a person releases it, however its messages arrive, and whichever node is started again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import permutations
from pathlib import Path

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.errors import MbdError
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import HIGHEST, StopCause, StopLatch
from mbd_msgs.msg import Stop
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

NUMBERS = st.tuples(st.integers(0, 9), st.integers(0, 9)).map(sorted)


def latch(numbers: list[int]) -> StopLatch:
    return StopLatch(numbers[1], numbers[0], reason=f"stop {numbers[1]}")


@given(st.lists(NUMBERS.map(latch), min_size=1, max_size=4))
def test_what_is_known_does_not_depend_on_the_order_in_which_it_is_received(received: list[StopLatch]):
    ends = set()
    for order in permutations(received):
        known = StopLatch()
        for one in order:
            known = known.merged(one).merged(one)
        ends.add(known)
    assert len(ends) == 1


@given(st.integers(0, 2**62), st.lists(st.sampled_from(["stop", "release"]), max_size=12))
def test_after_a_stop_nothing_but_a_release_lets_go_and_the_next_stop_holds_again(now: int, words: list[str]):
    known = StopLatch()
    for word in words:
        known = known.stop(now, StopCause.PERSON, "so") if word == "stop" else known.release()
        assert known.held == (word == "stop")


def test_a_stop_that_was_not_received_when_a_person_released_another_still_holds():
    first = StopLatch().stop(10, StopCause.PERSON, "one")
    second = first.stop(20, StopCause.EMERGENCY_STOP, "two")
    assert first.release().merged(second).held
    assert first.release().merged(second).reason == "two"


@pytest.mark.parametrize(("stopped", "released"), [(1, 2), (HIGHEST, 0), (-1, -1)])
def test_numbers_that_would_let_later_stops_go_by_are_refused(stopped: int, released: int):
    with pytest.raises(MbdError, match="at most the stop"):
        StopLatch(stopped, released)


class Desk:
    """Nodes with a stop line each in one process."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.nodes: dict[str, rclpy.node.Node] = {}

    def node(self, name: str) -> rclpy.node.Node:
        self.nodes[name] = rclpy.create_node(name, context=self.context)
        self.executor.add_node(self.nodes[name])
        return self.nodes[name]

    def line(self, name: str, state_dir: Path | str = "") -> StopLine:
        return StopLine(self.node(name), state_dir=str(state_dir))

    def end(self, name: str) -> None:
        node = self.nodes.pop(name)
        self.executor.remove_node(node)
        node.destroy_node()

    def until(self, done: Callable[[], bool]) -> None:
        end = time.monotonic() + 30.0
        while not done():
            assert time.monotonic() < end, "waited in vain"
            self.executor.spin_once(timeout_sec=0.02)


@pytest.fixture
def desk(ros_domain: int) -> Iterator[Desk]:
    made = Desk(ros_domain)
    yield made
    made.executor.shutdown()
    for name in list(made.nodes):
        made.nodes.pop(name).destroy_node()
    rclpy.try_shutdown(context=made.context)


def test_a_stop_reaches_every_node_and_holds_for_one_that_starts_after_who_said_it_has_gone(desk: Desk):
    one, two = desk.line("one"), desk.line("two")
    one.stop(StopCause.PERSON, "a hand on the stop")
    desk.until(lambda: two.latch.held)
    assert two.latch.reason == "a hand on the stop"
    desk.end("one")
    late = desk.line("late")
    desk.until(lambda: late.latch.held)
    late.release()
    desk.until(lambda: not two.latch.held)


def test_a_node_that_is_started_again_alone_still_stands(desk: Desk, tmp_path: Path):
    desk.line("one", tmp_path).stop(StopCause.EMERGENCY_STOP, "the red button")
    desk.end("one")
    assert desk.line("again", tmp_path).why == "stopped: the red button"


def test_a_kept_stop_that_cannot_be_read_as_one_stands_still(desk: Desk, tmp_path: Path):
    from rclpy.serialization import serialize_message

    (tmp_path / "stop.cdr").write_bytes(serialize_message(Stop(stopped=1, released=5)))
    assert desk.line("one", tmp_path).latch.held


def test_the_service_and_a_message_without_numbers_stop_and_diagnostics_say_so(desk: Desk):
    line, peer = desk.line("one"), desk.node("peer")
    reports: list[DiagnosticArray] = []
    peer.create_subscription(DiagnosticArray, "diagnostics", reports.append, EVENTS)
    client = peer.create_client(Trigger, "one/stop")
    desk.until(lambda: client.service_is_ready() and peer.count_publishers("diagnostics") > 0)
    desk.until(lambda: line._diagnostics.get_subscription_count() > 0)
    answer = client.call_async(Trigger.Request())
    desk.until(answer.done)
    assert answer.result().success and line.latch.cause is StopCause.PERSON
    desk.until(lambda: any(s.level == DiagnosticStatus.ERROR for r in reports for s in r.status))
    line.release()
    publisher = peer.create_publisher(Stop, "stop", LATCHED)
    publisher.publish(Stop(reason="from a shell"))
    desk.until(lambda: line.latch.held)
    assert line.why == "stopped: from a shell"


@pytest.mark.parametrize("broken", [Stop(cause=99, stopped=7), Stop(stopped=2**64 - 1), Stop(stopped=1, released=9)])
def test_a_stop_nobody_can_read_stops_all_the_same(desk: Desk, broken: Stop):
    line, peer = desk.line("one"), desk.node("peer")
    peer.create_publisher(Stop, "stop", LATCHED).publish(broken)
    desk.until(lambda: line.latch.held)
    line.release()
    assert not line.latch.held
    line.stop(StopCause.PERSON, "again")
    assert line.latch.held
