"""A node that is spun by a thread of its own while the rest of the process does something else."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Thread

import rclpy
from mbd_model.ros.spinning import LONGEST_WAIT, spin_until_shutdown
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

_PATIENCE = 40.0 * LONGEST_WAIT  # [s] for a callback that is running when the spin is to end


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

    over = Event()
    thread = Thread(target=spin_until_shutdown, args=(executor, over.is_set), daemon=True)
    thread.start()

    def end() -> None:
        over.set()
        executor.wake()
        thread.join(_PATIENCE)
        executor.shutdown(timeout_sec=_PATIENCE)
        node.destroy_node()
        rclpy.try_shutdown(context=node.context)

    return end
