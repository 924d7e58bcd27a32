"""A node that is spun by a thread of its own while the rest of the process does something else."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from threading import Thread

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


def spin_in_background(node: Node) -> Callable[[], None]:
    """Spin a node in a thread.

    Args:
        node: the node; its context is this function's from now on.

    Returns:
        What ends it: the thread, the node and its context. The node is destroyed, not only shut down: its latched
        publishers would otherwise go on talking in their domain for as long as the process lives.
    """
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    thread = Thread(target=spin, daemon=True)
    thread.start()

    def end() -> None:
        executor.shutdown()
        thread.join()
        node.destroy_node()
        rclpy.try_shutdown(context=node.context)

    return end
