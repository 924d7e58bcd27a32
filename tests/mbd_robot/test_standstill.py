from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from hypothesis import given
from hypothesis import strategies as st
from mbd_robot.joints import JointMerge
from mbd_robot.motion.standstill import Standstill, Stated
from mbd_robot.profiles.find import robot_profile
from mbd_robot.ros.moving.rest import at_rest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

CLOSED = robot_profile("jaco2").hand.closed


@given(
    st.lists(st.floats(0.05, 1.0), max_size=8),
    st.lists(st.integers(1, 3), min_size=12, max_size=12),
    st.booleans(),
)
def test_what_stands_counts_only_once_it_was_stated_twice_since_the_motion_s_end(steps, looks, known):
    """However far it still is, however often one looks between two statements: 10 Hz or 1 kHz."""
    values = [0.0]
    for step in steps:
        values.append(values[-1] + step)
    end = values[-1]
    values += [end, end]
    still = Standstill(Stated(0, (values[0],)) if known else None, tolerance=0.04)
    stated: list[float] = []
    for number, value in enumerate(values[known:], start=1):
        stated.append(value)
        stood = [still.stands(Stated(number, (value,))) for _ in range(looks[number - 1])]
        assert not any(stood[1:])
        if stood[0]:
            break
    assert stated[-1] == end
    assert len(stated) >= 2


def test_a_value_that_trembles_for_ever_is_taken_as_it_is():
    still = Standstill(None, tolerance=0.0)
    assert [still.stands(Stated(k, (k % 2,))) for k in range(1, 21)] == [False] * 19 + [True]


def test_statements_are_counted_though_their_stamps_stand():
    merge = JointMerge((), ("left", "right"))
    assert merge.hand_stated() is None
    for value in (0.2, 0.4):
        merge.take(0.0, ("left",), (value,))
        merge.take(0.0, ("right",), (value,))
    assert merge.hand_stated() == Stated(2, (0.4,))


@contextmanager
def waiting(domain: int) -> Iterator[tuple[Node, SingleThreadedExecutor]]:
    context = rclpy.Context()
    rclpy.init(context=context, args=[], domain_id=domain)
    node = rclpy.create_node("waits", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def test_a_hand_whose_joints_are_stated_late_is_waited_for(ros_domain: int):
    """The fault: 10 statements a second, the fourth still on the way; the last one before the end counted."""
    with waiting(ros_domain) as (node, executor):
        merge = JointMerge((), ("finger",))
        merge.take(0.0, ("finger",), (0.186,))
        late = iter([0.1, 0.03, 0.0, 0.0])
        node.create_timer(0.1, lambda: merge.take(0.0, ("finger",), (next(late, 0.0),)))
        task = executor.create_task(at_rest, node, merge.hand_stated, 0.01 * CLOSED)
        executor.spin_until_future_complete(task, timeout_sec=60.0)
        assert task.done()
        assert merge.hand_position() == 0.0


def test_a_hand_that_never_states_its_joints_is_not_waited_for(ros_domain: int):
    with waiting(ros_domain) as (node, executor):
        task = executor.create_task(at_rest, node, lambda: None, 0.01, 0.1)
        executor.spin_until_future_complete(task, timeout_sec=60.0)
        assert task.done()
