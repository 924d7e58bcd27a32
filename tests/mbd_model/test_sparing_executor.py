"""The nodes' executor does what rclpy's does, for less."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from mbd_model.ros.sparing_executor import EVENT_PERIOD, SparingExecutor
from mbd_msgs.action import MoveTool
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Int32
from std_srvs.srv import Trigger


@pytest.fixture
def node(ros_domain: int) -> Iterator[Node]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = Node("spared", context=context)
    yield node
    node.destroy_node()
    rclpy.try_shutdown(context=context)


@pytest.fixture
def executor(node: Node) -> Iterator[SparingExecutor]:
    executor = SparingExecutor(context=node.context)
    executor.add_node(node)
    yield executor
    executor.shutdown()


def spin_until(executor: SparingExecutor, done: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        executor.spin_once(timeout_sec=0.1)


def test_each_message_is_received_once_and_in_order_one_a_spin(node: Node, executor: SparingExecutor):
    plain: list[int] = []
    with_info: list[tuple[int, int]] = []
    raw: list[bytes] = []
    node.create_subscription(Int32, "number", lambda m: plain.append(m.data), 100)
    node.create_subscription(Int32, "number", lambda m, i: with_info.append((m.data, i["source_timestamp"])), 100)
    node.create_subscription(Int32, "number", raw.append, 100, raw=True)
    out = node.create_publisher(Int32, "number", 100)
    spin_until(executor, lambda: out.get_subscription_count() == 3)
    for number in range(50):
        out.publish(Int32(data=number))
    received = 0
    while received < 150:
        executor.spin_once(timeout_sec=10.0)
        assert len(plain) + len(with_info) + len(raw) - received <= 1
        received = len(plain) + len(with_info) + len(raw)
    assert plain == [number for number, _ in with_info] == list(range(50))
    assert all(stamp > 0 for _, stamp in with_info)
    assert {type(data) for data in raw} == {bytes}


def test_a_service_that_waits_for_another_is_answered_while_its_group_takes_nothing_else(
    node: Node, executor: SparingExecutor
):
    asked: Future[Trigger.Response] = Future()
    taken: list[int] = []
    group = MutuallyExclusiveCallbackGroup()
    inner = node.create_client(Trigger, "inner", callback_group=ReentrantCallbackGroup())
    node.create_service(Trigger, "inner", lambda _, r: r, callback_group=ReentrantCallbackGroup())

    async def outer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        await inner.call_async(Trigger.Request())
        await asked
        response.message = str(len(taken))
        return response

    node.create_service(Trigger, "outer", outer, callback_group=group)
    node.create_subscription(Int32, "number", lambda m: taken.append(m.data), 10, callback_group=group)
    others: list[int] = []
    node.create_subscription(Int32, "number", lambda m: others.append(m.data), 10)
    out = node.create_publisher(Int32, "number", 10)
    client = node.create_client(Trigger, "outer")
    spin_until(executor, lambda: client.service_is_ready() and inner.service_is_ready())
    spin_until(executor, lambda: out.get_subscription_count() == 2)
    answer = client.call_async(Trigger.Request())
    spin_until(executor, lambda: group_is_taken(group))
    out.publish(Int32(data=1))
    spin_until(executor, lambda: others)
    assert taken == []
    asked.set_result(Trigger.Response())
    spin_until(executor, lambda: answer.done() and taken)
    assert answer.result().message == "0"


def group_is_taken(group: MutuallyExclusiveCallbackGroup) -> bool:
    return not all(group.can_execute(entity()) for entity in group.entities)


def test_an_action_is_accepted_fed_back_and_ended(node: Node, executor: SparingExecutor):
    async def move(goal: object) -> MoveTool.Result:
        goal.publish_feedback(MoveTool.Feedback())
        goal.succeed()
        return MoveTool.Result()

    server = ActionServer(node, MoveTool, "move", move)
    client = ActionClient(node, MoveTool, "move")
    feedback: list[object] = []
    spin_until(executor, client.server_is_ready)
    sent = client.send_goal_async(MoveTool.Goal(), feedback_callback=feedback.append)
    spin_until(executor, sent.done)
    result = sent.result().get_result_async()
    spin_until(executor, lambda: result.done() and feedback)
    assert result.result().status == 4  # SUCCEEDED
    client.destroy()
    server.destroy()


def test_timers_go_at_their_rate_and_not_after_they_were_cancelled(node: Node, executor: SparingExecutor):
    times: list[float] = []
    timer = node.create_timer(0.02, lambda: times.append(time.monotonic()))
    spin_until(executor, lambda: len(times) == 5)
    assert times[-1] - times[0] >= 0.06
    timer.cancel()
    executor.spin_once(timeout_sec=0.1)
    assert len(times) == 5


def test_what_a_callback_raises_is_raised_by_the_spin(node: Node, executor: SparingExecutor):
    def fails() -> None:
        raise KeyError("plain")

    async def fails_later() -> None:
        raise KeyError("later")

    for callback, what in ((fails, "plain"), (fails_later, "later")):
        timer = node.create_timer(0.001, callback)
        with pytest.raises(KeyError, match=what):
            spin_until(executor, lambda: False)
        timer.destroy()


def test_a_task_and_a_new_topic_wake_a_spin_that_waits_without_end(node: Node, executor: SparingExecutor):
    executor.spin_once(timeout_sec=0.0)
    done = threading.Event()
    waiting = threading.Timer(0.1, executor.create_task, (done.set,))
    waiting.start()
    executor.spin_once()
    assert done.is_set()
    received: list[int] = []
    out = node.create_publisher(Int32, "number", 10)

    def subscribe() -> None:
        node.create_subscription(Int32, "number", lambda m: received.append(m.data), 10)
        while not out.get_subscription_count():
            time.sleep(0.01)
        out.publish(Int32(data=1))

    late = threading.Thread(target=subscribe)
    late.start()
    while not received:
        executor.spin_once()
    late.join()


def test_what_is_destroyed_while_it_is_ready_is_passed_over(node: Node, executor: SparingExecutor):
    received: list[int] = []
    subscriptions = []

    def destroy_the_other(number: int) -> None:
        received.append(number)
        node.destroy_subscription(subscriptions[1 - number])

    for number in range(2):
        subscriptions.append(node.create_subscription(Int32, "n", lambda _, n=number: destroy_the_other(n), 10))
    out = node.create_publisher(Int32, "n", 10)
    spin_until(executor, lambda: out.get_subscription_count() == 2)
    out.publish(Int32())
    spin_until(executor, lambda: received)
    for _ in range(3):
        executor.spin_once(timeout_sec=0.1)
    assert len(received) == 1


def test_a_publisher_of_another_quality_is_noticed(node: Node, executor: SparingExecutor):
    events: list[object] = []
    node.create_subscription(
        Int32,
        "number",
        lambda _: None,
        QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE),
        event_callbacks=SubscriptionEventCallbacks(incompatible_qos=events.append),
    )
    node.create_publisher(Int32, "number", QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    spin_until(executor, lambda: events, 20.0 * EVENT_PERIOD)


def test_a_context_that_is_shut_down_ends_the_spin(node: Node, executor: SparingExecutor):
    threading.Timer(0.1, rclpy.shutdown, kwargs={"context": node.context}).start()
    with pytest.raises(ExternalShutdownException):
        spin_until(executor, lambda: False)


def test_a_look_at_many_topics_takes_less_of_the_processor_than_rclpys(node: Node, executor: SparingExecutor):
    for number in range(40):
        node.create_subscription(Int32, f"number_{number}", lambda _: None, 1)

    def cost(spinning: SparingExecutor | SingleThreadedExecutor) -> float:
        spinning.spin_once(timeout_sec=0.0)
        begun = time.thread_time()
        for _ in range(100):
            spinning.spin_once(timeout_sec=0.0)
        return time.thread_time() - begun

    spared = cost(executor)
    executor.remove_node(node)
    rclpys = SingleThreadedExecutor(context=node.context)
    rclpys.add_node(node)
    assert spared < 0.6 * cost(rclpys)
