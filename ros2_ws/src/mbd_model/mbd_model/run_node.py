"""The life of a node's process, the same for every node: started, spun, ended without a traceback.

In Jazzy ``rclpy.init()`` is no context manager, SIGINT may reach a node twice, and a timer can publish into a context
that has just been shut down: none of these is an error.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from mbd_model.errors import MbdError


def run_node(name: str, make_node: Callable[[], Node]) -> None:
    """Make the node and spin it until Ctrl-C or shutdown.

    Args:
        name: under which a failure to start is logged.
        make_node: makes it; rclpy is initialised when it is called.

    Raises:
        SystemExit: code 1 when the node could not be made of its parameters; the log says why.
    """
    rclpy.init()
    try:
        executor = SingleThreadedExecutor()
        executor.add_node(make_node())
        executor.spin()
    except (MbdError, InvalidParameterValueException, InvalidParameterTypeException) as error:
        rclpy.logging.get_logger(name).fatal(str(error))
        sys.exit(1)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        # A publish after the context was shut down from outside; anything else is an error.
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()
