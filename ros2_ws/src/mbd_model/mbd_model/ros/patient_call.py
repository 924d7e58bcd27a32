"""Call a service whose answer may never come: a node that died or hangs must not keep the caller waiting."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


def call_within(
    node: Node,
    client: Client[RequestT, ResponseT],
    request: RequestT,
    patience: float,
    answered: Callable[[ResponseT | None], None],
) -> None:
    """Call a service; the answer is given to ``answered``, exactly once, in the node's executor.

    Args:
        node: the caller.
        client: of the node.
        request: what to send.
        patience: how long to wait for the answer [s, steady clock: simulated time may stand still].
        answered: takes the response, None when there was none in time.
    """
    open_calls: list[Future[ResponseT]] = []

    def end(response: ResponseT | None) -> None:
        if open_calls:
            open_calls.clear()
            node.destroy_timer(timer)
            answered(response)

    def give_up() -> None:
        for future in open_calls:
            client.remove_pending_request(future)
        end(None)

    timer = node.create_timer(patience, give_up, clock=Clock(clock_type=ClockType.STEADY_TIME))
    future = client.call_async(request)
    open_calls.append(future)
    future.add_done_callback(lambda done: end(done.result()))
