"""The life of a node's process, the same for every node: started, spun, ended without a traceback.

In Jazzy ``rclpy.init()`` is no context manager, SIGINT may reach a node twice, and a timer can publish into a context
that has just been shut down: none of these is an error.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TypeVar

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from mbd_model.errors import MbdError

# What a node raises when it cannot be made of the parameters it was given.
START_FAILURES = (MbdError, InvalidParameterTypeException, InvalidParameterValueException)
AnyNode = TypeVar("AnyNode", bound=Node)


def explained(error: Exception) -> str:
    """Text of one of START_FAILURES that also says what to do."""
    if isinstance(error, InvalidParameterTypeException):
        # ROS reads a parameter as YAML, where 3 is no 3.0, and 07 no text.
        return f"{error}; write a DOUBLE with a point (3.0), a STRING that looks like a number in quotes (\"'07'\")"
    return str(error)


def spin_alone(node: Node) -> None:
    """Spin a node in an executor of its own."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.spin()


def run_node(name: str, make_node: Callable[[], AnyNode], spin: Callable[[AnyNode], None] = spin_alone) -> None:
    """Make the node and spin it until Ctrl-C or shutdown.

    Args:
        name: under which a failure to start is logged.
        make_node: makes it; rclpy is initialised when it is called.
        spin: runs it; returns or raises when the context is shut down.

    Raises:
        SystemExit: code 1 when the node could not be made of its parameters; the log says why.
    """
    rclpy.init()
    try:
        spin(make_node())
    except START_FAILURES as error:
        rclpy.logging.get_logger(name).fatal(explained(error))
        sys.exit(1)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        # A publish after the context was shut down from outside; anything else is an error.
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()
