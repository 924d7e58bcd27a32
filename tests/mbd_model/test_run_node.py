"""A node's process ends with a word, not with a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest
import rclpy
from mbd_model.errors import MbdError
from mbd_model.ros.run_node import run_node
from mbd_msgs.action import MoveTool
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action import ActionClient
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Header


@pytest.fixture(autouse=True)
def like_a_process(ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(ros_domain))
    monkeypatch.setattr(sys, "argv", ["tested"])
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)


def node_with(given: object, default: object) -> Callable[[], Node]:
    """Makes a node that declares a parameter with that default, while the command line gave that value."""

    def make() -> Node:
        node = Node("tested", parameter_overrides=[Parameter("pace", value=given)])
        node.declare_parameter("pace", default)
        return node

    return make


@pytest.mark.parametrize(
    ("given", "default", "advice"),
    [(3, 1.0, "write a DOUBLE with a point (3.0)"), (7, "", "a STRING that looks like a number in quotes")],
)
def test_a_parameter_of_the_wrong_type_is_refused_with_its_name_and_how_to_write_it(given, default, advice, capfd):
    with pytest.raises(SystemExit) as ended:
        run_node("tested", node_with(given, default))
    assert ended.value.code == 1
    output = capfd.readouterr().err
    assert "'pace'" in output
    assert advice in output
    assert "Traceback" not in output
    assert not rclpy.ok()


@pytest.mark.parametrize(
    ("words", "output"),
    [
        (["pace:=1.0"], "'pace:=1.0' on the command line means nothing here; parameters are given as: --ros-args -p"),
        (["--ros-args", "-p", "pace:=1.0", "--", "pace:=fast"], "'pace:=fast' on the command line means nothing here"),
        (["--ros-args", "pace:=1.0"], "ROS cannot use the command line: ['pace:=1.0']; parameters are given as"),
        (["--ros-args", "-p", "pace=1.0"], "Couldn't parse parameter override rule: '-p pace=1.0'"),
        (["--ros-args", "--params-file", "/nowhere.yaml"], "the parameter file /nowhere.yaml cannot be read"),
    ],
)
def test_words_that_mean_nothing_are_refused_in_one_line_with_what_would(words, output, capfd, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["tested", *words])
    with pytest.raises(SystemExit) as ended:
        run_node("tested", lambda: Node("tested"))
    assert ended.value.code == 1
    lines = capfd.readouterr().err.strip().splitlines()
    assert output in lines[-1]
    assert ", at /" not in lines[-1]
    # ROS itself has output before that it cannot read a file or a rule, no more.
    assert all("[rcl]" in line for line in lines[:-1])


def test_an_error_of_ours_is_the_last_word(capfd):
    def make() -> Node:
        raise MbdError("no such task; there are stacking and sorting")

    with pytest.raises(SystemExit) as ended:
        run_node("tested", make)
    assert ended.value.code == 1
    assert "no such task" in capfd.readouterr().err


LIVING = """
import time
from mbd_model.ros.run_node import run_node
from mbd_model.ros.spinning import spin_until_shutdown
from rclpy.node import Node

def spin(executor, node):
    print("spinning", flush=True)
    try:
        spin_until_shutdown(executor)
    finally:
        print("closing", flush=True)
        time.sleep(0.2)
        print("closed", flush=True)

run_node("living", lambda: Node("living"), spin)
"""


@pytest.mark.parametrize("signals", [[signal.SIGINT], [signal.SIGINT] * 3, [signal.SIGTERM, signal.SIGINT]])
def test_it_closes_in_peace_however_often_it_is_asked_to_stop(signals):
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", LIVING], stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout.readline() == "spinning\n"
        process.send_signal(signals[0])
        assert process.stdout.readline() == "closing\n"
        for another in signals[1:]:
            process.send_signal(another)
        rest, output = process.communicate(timeout=60)
    assert (process.returncode, rest, output) == (0, "closed\n", "")


def test_asked_by_a_signal_it_states_where_it_is_and_goes_on():
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", LIVING], stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout.readline() == "spinning\n"
        process.send_signal(signal.SIGUSR1)
        output = iter(process.stderr.readline, "")
        assert any(" in spin\n" in line for line in output)
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
    assert (process.returncode, rest) == (0, "closing\nclosed\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_comes_while_ros_starts_is_not_lost(number, monkeypatch):
    start = rclpy.init

    def interrupted() -> None:
        signal.raise_signal(number)
        start()

    monkeypatch.setattr(rclpy, "init", interrupted)
    run_node("tested", lambda: pytest.fail("the node was made all the same"))
    assert not rclpy.ok()


def test_a_message_published_after_the_end_is_no_failure():
    def publish_too_late(_: Executor, node: Node) -> None:
        publisher = node.create_publisher(Header, "late", 1)
        node.context.shutdown()
        with pytest.raises(RCLError):
            publisher.publish(Header())
        publisher.publish(Header())

    run_node("tested", lambda: Node("tested"), publish_too_late)


def test_a_node_whose_context_is_shut_down_while_it_is_made_is_no_failure():
    def make() -> Node:
        node = Node("tested")
        node.context.shutdown()
        ActionClient(node, MoveTool, "move_tool")  # raises no error of rclpy's but a bare ValueError
        return node

    run_node("tested", make)
    assert not rclpy.ok()


@pytest.mark.parametrize("error", [ZeroDivisionError, ValueError])
def test_any_other_error_is_raised_and_the_context_shut_down(error):
    def break_down(_: Executor, __: Node) -> None:
        raise error

    with pytest.raises(error):
        run_node("tested", lambda: Node("tested"), break_down)
    assert not rclpy.ok()
