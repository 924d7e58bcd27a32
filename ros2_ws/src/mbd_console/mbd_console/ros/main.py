"""``console``: the web server and the node behind it, in one process."""

from __future__ import annotations

import argparse
import os
import sys
import threading

import rclpy
from mbd_model.command_line.parser import CommandParser
from mbd_model.ros.leaving import leave
from mbd_model.ros.run_node import START_FAILURES, explained
from mbd_model.ros.signals import StopRequest
from mbd_model.ros.spinning import LONGEST_WAIT, spin_until_shutdown
from mbd_model.ros.starting.command_line import init_ros, other_words
from mbd_model.ros.starting.node_help import parameter_lines
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from mbd_console.access.port import refuse_taken_port
from mbd_console.access.rule import access_rule
from mbd_console.parameters import CONSOLE
from mbd_console.ros.console_node import ConsoleNode
from mbd_console.server import serve

TOKEN_VARIABLE, OBSERVER_VARIABLE = "MBD_CONSOLE_TOKEN", "MBD_CONSOLE_OBSERVER_TOKEN"
_PATIENCE = 20.0 * LONGEST_WAIT  # [s] that the spinning thread has to see that the context is shut down


def _arguments() -> argparse.Namespace:
    parser = CommandParser(
        prog="console",
        description="The wizard's console: a web page for the operator.",
        epilog="\n".join(parameter_lines([CONSOLE])),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    # No ROS parameter: the recorder keeps every node's parameters in the bag.
    parser.add_argument(
        "--token",
        default=os.environ.get(TOKEN_VARIABLE, ""),
        help=f"opens the console to the network, for those who know it (or variable {TOKEN_VARIABLE})",
    )
    parser.add_argument(
        "--observer-token",
        default=os.environ.get(OBSERVER_VARIABLE, ""),
        help=f"lets who knows it see the participant's view, and do nothing (or variable {OBSERVER_VARIABLE})",
    )
    return parser.parse_args(other_words(sys.argv[1:]))


def main() -> None:
    """Serve the console until Ctrl-C or shutdown: ROS in a thread of its own, the web server in this one."""
    stop = StopRequest()
    arguments = _arguments()
    # Inherited from a test that starts this process, it would make NiceGUI believe that it is itself under test.
    os.environ.pop("PYTEST_CURRENT_TEST", None)
    # While it runs the web server handles the signals, so that pages are closed before the node goes.
    listening: threading.Thread | None = None
    node: ConsoleNode | None = None
    try:
        init_ros(signal_handler_options=SignalHandlerOptions.NO)
        node = ConsoleNode()
        rule = access_rule(node.host, arguments.token, arguments.observer_token)
        refuse_taken_port(rule.host, node.port)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        listening = threading.Thread(target=spin_until_shutdown, args=(executor,), daemon=True)
        listening.start()
        # Not the token: what is logged goes into the bag.
        asked = "; it asks for the token" if rule.token else ""
        node.get_logger().info(f"console at http://{rule.host}:{node.port}/, for the participant at /observe{asked}")
        serve(node.desk, rule, node.port, lambda: bool(stop))
    except START_FAILURES as error:
        raise SystemExit(f"console: {explained(error)}") from error
    finally:
        rclpy.try_shutdown()
        # However it ends: a thread still inside rclpy would abort the process on its way out.
        if listening is not None:
            listening.join(_PATIENCE)
        leave(None if listening is not None and listening.is_alive() else node)


if __name__ == "__main__":
    main()
