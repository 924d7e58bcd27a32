"""The plan's next session is offered to the operator's page, and begins by that page's word and by no other."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from mbd_bringup.ros.next_offer import NextOffer
from mbd_console.requests import BeginSession
from mbd_console.ros.console_node import ConsoleNode
from mbd_model.ros.qos import EVENTS
from mbd_msgs.msg import NextSession
from mbd_study.plan.schedule import PlannedSession, planned_sessions
from mbd_study.plan.study_plan import read_plan
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

PLAN = "study: s\nseed: 1\nconditions: [mbd]\ntasks: [sorting]\nparticipants: [p1, p2]\n"
Until = Callable[[Callable[[], object]], None]


@pytest.fixture
def spinning(ros_domain: int) -> Iterator[tuple[Node, ConsoleNode, Until]]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    leader, console = Node("leader", context=context), ConsoleNode(context=context)
    executor = SingleThreadedExecutor(context=context)
    for node in (leader, console):
        executor.add_node(node)

    def until(so: Callable[[], object]) -> None:
        end = time.monotonic() + 60
        while not so():
            assert time.monotonic() < end, "it did not come to that"
            executor.spin_once(timeout_sec=0.05)
            console.desk.catch_up()

    yield leader, console, until
    rclpy.shutdown(context=context)


@pytest.fixture
def second(tmp_path: Path) -> PlannedSession:
    (tmp_path / "plan.yaml").write_text(PLAN)
    return planned_sessions(read_plan(tmp_path / "plan.yaml"))[1]


@pytest.mark.parametrize(
    ("problem", "pressed"), [("", "p9_mbd_sorting"), ("", ""), ("the folder cannot be written", "")]
)
def test_what_the_plan_has_next_comes_to_the_page_and_no_other_word_begins_it(
    spinning: tuple[Node, ConsoleNode, Until], second: PlannedSession, problem: str, pressed: str
):
    """A press for another session, or while something is in the way, begins nothing; ``pressed`` "": the right one."""
    leader, console, until = spinning
    came: list[NextSession] = []
    leader.create_subscription(NextSession, "session/begin", came.append, EVENTS)
    offer = NextOffer(leader)
    until(lambda: leader.count_publishers("session/begin") and console.count_publishers("session/next"))
    until(lambda: console.count_subscribers("session/begin") == 2)
    offer.offer(second, problem)
    until(lambda: console.desk.state.offered)
    shown = console.desk.state.offered
    assert (shown.session, shown.participant, shown.problem) == (second.session, second.participant, problem)
    console.desk.send(BeginSession(pressed or second.session))
    until(lambda: came)
    if pressed or problem:
        assert not offer.begun
    else:
        until(lambda: offer.begun)
