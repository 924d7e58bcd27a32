"""How a node leaves: gone for the others at once, its process without cleaning the memory that ends with it."""

from __future__ import annotations

import atexit
import gc

import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node


def leave(node: Node | None) -> None:
    """Shut the context down and take a node out of it: the end of a process, when nothing of the node runs any more.

    The participant is removed here and now, so that the others do not take the node for being there until its lease
    ends. All that follows is Python's own end: handlers of ``atexit`` run, the exit code stays, what was written gets
    out. Only the search for garbage is spared, of which an interpreter makes three at its end: nine tenths of what a
    node with numpy, Open3D or NiceGUI took to end. Synapse and Spack end by ``gc.freeze`` for the same reason;
    ``os._exit`` would save a few milliseconds more, and skip coverage and removing temporary folders.

    So an object that is alive at the end is not finalised any more: a file with a buffer has to be closed by who
    opened it.

    Args:
        node: of the default context; None where none was made.
    """
    rclpy.try_shutdown()
    if node is None:
        return
    # destroy_node leaves these alone, and each of them keeps the participant.
    for waitable in tuple(node.waitables):
        if isinstance(waitable, ActionClient | ActionServer):
            waitable.destroy()
    node.destroy_node()
    atexit.register(gc.freeze)
