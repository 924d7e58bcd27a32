"""A spin ends although nothing wakes it."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest
import rclpy
from mbd_model.ros.qos import EVENTS
from mbd_model.ros.spinning import LONGEST_WAIT, spin_for, spin_until_shutdown
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import Int32


@pytest.fixture
def context(ros_domain: int) -> Iterator[Context]:
    context = Context()
    rclpy.init(context=context, domain_id=ros_domain)
    yield context
    rclpy.try_shutdown(context=context)


@pytest.fixture
def executor(context: Context) -> Iterator[SingleThreadedExecutor]:
    """With a node whose clock stands, and with it the node's timer."""
    node = Node("idle", context=context, parameter_overrides=[Parameter("use_sim_time", value=True)])
    node.create_timer(0.01, lambda: None)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield executor
    node.destroy_node()


def spin_in_thread(executor: SingleThreadedExecutor, *words: object) -> threading.Thread:
    """A thread that spins it, once it has nothing more to do than to wait."""
    thread = threading.Thread(target=spin_until_shutdown, args=(executor, *words), daemon=True)
    thread.start()
    thread.join(2.0 * LONGEST_WAIT)
    assert thread.is_alive(), "the spin ended before anything ended it"
    return thread


def test_a_context_shut_down_without_waking_anybody_ends_the_spin(context, executor):
    # What rclpy's own handler does when its thread is held up for a moment: it wakes the executor, which still finds
    # the context in order and waits again, and then shuts the context down, of which the executor does not learn.
    thread = spin_in_thread(executor)
    executor.wake()
    time.sleep(LONGEST_WAIT / 2.0)
    with context.handle:
        context.handle.shutdown()
    thread.join(20.0)
    assert not thread.is_alive()


def test_the_spin_ends_when_it_is_over_although_the_context_goes_on(context, executor):
    over = threading.Event()
    thread = spin_in_thread(executor, over.is_set)
    over.set()
    thread.join(20.0)
    assert not thread.is_alive()
    assert context.ok()


def test_the_longest_wait_leaves_most_of_the_second_in_which_a_node_is_to_end():
    assert LONGEST_WAIT <= 0.25


@pytest.mark.parametrize("wait", [0.0, 0.004, 0.03])
def test_messages_are_taken_in_waits_of_any_length_while_an_action_is_under_way(context, wait: float):
    node = Node("busy", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    came: list[int] = []
    node.create_subscription(Int32, "number", lambda msg: came.append(msg.data), EVENTS)
    out = node.create_publisher(Int32, "number", EVENTS)
    end = Future(executor=executor)

    async def action() -> None:
        await end

    task = executor.create_task(action)
    while not out.get_subscription_count():
        spin_for(executor, wait)
    for number in range(20):
        out.publish(Int32(data=number))
        for turn in range(100):
            if len(came) > number:
                break
            spin_for(executor, wait + 1e-6 * turn)
    assert came == list(range(20))
    assert not task.done()
    end.set_result(None)
    while not task.done():
        spin_for(executor, wait)
    node.destroy_node()
