"""The life of a node's process, the same for every node: started, spun, ended without a traceback.

In Jazzy ``rclpy.init()`` is no context manager, SIGINT may reach a node twice (from the terminal and from what started
it), and a timer can publish into a context that has just been shut down: none of these is an error.
"""

from __future__ import annotations

import faulthandler
import signal
import sys
from collections.abc import Callable
from typing import TypeVar

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import (
    InvalidHandle,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    NotInitializedException,
)
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from mbd_model.errors import MbdError
from mbd_model.ros.leaving import leave
from mbd_model.ros.signals import StopRequest
from mbd_model.ros.spinning import spin_until_shutdown
from mbd_model.ros.starting.command_line import init_ros, refuse_other_words
from mbd_model.ros.starting.loopback import LoopbackWatch, begin_again
from mbd_model.ros.starting.node_help import answer_help

# What a node raises when it cannot be made of the parameters it was given.
START_FAILURES = (MbdError, InvalidParameterTypeException, InvalidParameterValueException)
# What rclpy raises for something made or published in a context that was shut down from outside: action clients answer
# with a bare ValueError.
_TOO_LATE = (RCLError, NotInitializedException, InvalidHandle, ValueError)
AnyNode = TypeVar("AnyNode", bound=Node)


def explained(error: Exception) -> str:
    """Text of one of START_FAILURES that also states what to do."""
    if isinstance(error, InvalidParameterTypeException):
        # ROS reads a parameter as YAML, where 3 is no 3.0, and 07 no text.
        return f"{error}; write a DOUBLE with a point (3.0), a STRING that looks like a number in quotes (\"'07'\")"
    return str(error)


def run_node(
    name: str, make_node: Callable[[], AnyNode], spin: Callable[[Executor, AnyNode], None] | None = None
) -> None:
    """Make the node and spin it until Ctrl-C or shutdown. For a process's main thread.

    Args:
        name: under which a failure to start is logged.
        make_node: makes it; rclpy is initialised when it is called.
        spin: runs the node in its executor; returns or raises when the context is shut down, and never waits for
            long at once. None: ``spin_until_shutdown``.

    Raises:
        SystemExit: code 1 when the node could not be made of its command line and parameters; the log states why.
    """
    # First, so that no signal is lost. rclpy's handler besides shuts the context down, which ends the spin. Python's
    # own would raise KeyboardInterrupt wherever it is, at the second Ctrl-C amid closing.
    stop = StopRequest()
    node: AnyNode | None = None
    # Asked by this signal, a node that hangs writes where each of its threads is.
    faulthandler.register(signal.SIGUSR1, all_threads=True)
    try:
        answer_help(name, make_node)
        refuse_other_words()
        watch = LoopbackWatch()
        init_ros()
        if stop:
            return
        executor = SingleThreadedExecutor()
        node = make_node()
        if watch.went_down() and not stop:
            # What it joined by then has no address, and will have none.
            node.get_logger().warning("the network of this machine was away while this node joined it: once more")
            begin_again()
        executor.add_node(node)
        if spin is None:
            spin_until_shutdown(executor, lambda: bool(stop))
        else:
            spin(executor, node)
    except START_FAILURES as error:
        rclpy.logging.get_logger(name).fatal(explained(error))
        sys.exit(1)
    except ExternalShutdownException:
        pass
    except _TOO_LATE:
        if rclpy.ok():
            raise  # not too late: an error
    finally:
        leave(node)
