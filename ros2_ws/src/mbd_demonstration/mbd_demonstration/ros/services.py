"""A service's answer: the sentence of what was done, or why not."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger


def answered(node: Node, answer: Callable[[], str]) -> tuple[str, bool]:
    """(message, success) of a service: what ``answer`` returns, or the ValueError it raises; both are logged."""
    try:
        message = answer()
    except ValueError as error:  # MbdError is one
        node.get_logger().warning(str(error))
        return str(error), False
    node.get_logger().info(message)
    return message, True


def serve_trigger(node: Node, name: str, answer: Callable[[], str]) -> None:
    """Serve a Trigger; ``answer()`` returns the sentence of success or raises MbdError with why not."""

    def callback(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message, response.success = answered(node, answer)
        return response

    node.create_service(Trigger, name, callback)
