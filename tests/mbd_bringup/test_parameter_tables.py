"""Every node declares its table, refuses what is not in it, and the page of parameters shows the same."""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from mbd_bag.replay.replay_options import ReplayOptions
from mbd_bag.replay.replay_plan import published_topics
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.session.session_facts import parameters_of
from mbd_bag.spool.parameters import WRITERS
from mbd_bag.storage.bag import Bag
from mbd_bringup.domain import private_domain
from mbd_bringup.launch_arguments import ARGUMENTS, refuse_unknown
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.parameter_page import TABLES, parameter_page, with_parameters
from mbd_model.errors import MbdError
from mbd_model.parameters import ROS_NAMES, ParameterError, ParameterSpec, ParameterTable
from mbd_model.ros.parameters import TableNode
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.parameter import Parameter

pytestmark = pytest.mark.node

ROOT = Path(__file__).resolve().parents[2]
SRC = ROOT / "ros2_ws" / "src"
BY_NODE = {table.node: table for table in TABLES}
SPECS = [pytest.param(spec, id=f"{table.node}-{spec.name}") for table in TABLES for spec in table.specs]
NODES = {
    "perception": "mbd_perception.ros.node",
    "demonstration": "mbd_demonstration.ros.node",
    "interaction": "mbd_interaction.ros.node",
    "execution": "mbd_execution.ros.node",
    "console": "mbd_console.ros.console_node",
    "mapping": "mbd_mapping.ros.node",
    "recorder": "mbd_bag.ros.recorder_node",
    "spool": "mbd_bag.ros.spool_node",
    "second_spool": "mbd_bag.ros.spool_node",
    "replay": "mbd_bag.ros.replay_node",
    "cell": "mbd_cell.ros.cell_node",
    "wizard": "mbd_cell.ros.wizard_node",
    "markers": "mbd_bringup.ros.markers_node",
    "robot": "mbd_robot.ros.robot_node",
    "camera": "mbd_robot.ros.camera_node",
}

# Parameters that the versions which recorded bags/ did not have yet.
LATER = {
    "grasp",
    "look_again",
    "observe",
    "look_from",
    "hand_zone",
    "run",
    "spool",
    "file_size",
    "end_with_session",
    "plan",
    "memory",
    "image_transport",
    "arm_description",
    "finger_min_turn",
    "finger_deep",
    "finger_rest",
    "finger_settle",
    "lift",
    "drop",
    "distance_noise",
    "doubt_asked",
    "promise",
    "doubt_at",
    "open_cost",
    "yes_no_cost",
    "which_of_two_cost",
    "feature_prior",
    "question_kinds",
    "segmenter",
    "tool_pose",
    "joint_state",
    "heartbeat",
    "robot",
    "camera",
    "room_dir",
}


@pytest.fixture(scope="module")
def context() -> Iterator[rclpy.Context]:
    """A ROS context in a domain of its own."""
    made = rclpy.Context()
    with private_domain() as domain:
        rclpy.init(context=made, args=[], domain_id=domain)
        yield made
        rclpy.try_shutdown(context=made)


@pytest.fixture
def make(context: rclpy.Context, tmp_path: Path, made_bag: Path) -> Iterator[Callable[..., TableNode]]:
    """Makes the node of that name with these parameters; it is destroyed when the test ends."""
    with contextlib.ExitStack() as stack:

        def made(name: str, **given: Any) -> TableNode:
            module = importlib.import_module(NODES[name])
            kinds = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, TableNode)]
            kind = next(k for k in kinds if k.__module__ == module.__name__)
            arguments: tuple[Any, ...] = ()
            if name == "recorder":
                given = {"bag": str(tmp_path / "bag"), "min_free": 1.0, **given}
            if name in WRITERS:
                arguments = (BY_NODE[name],)
                given = {"folder": str(tmp_path / "spool"), **given}
            if name == "replay":
                bag = Bag(made_bag)
                arguments = bag, session_from_bag(bag), ReplayOptions(published_topics(bag), bag.start)
            overrides = [Parameter(n, value=v) for n, v in given.items()]
            node = kind(*arguments, context=context, parameter_overrides=overrides)
            stack.callback(node.destroy_node)
            if name == "recorder":
                stack.callback(node.close)
            return node

        yield made


def plain(value: Any) -> Any:
    """A parameter's value without the kind of its sequence, and with NaN equal to itself."""
    if isinstance(value, float) and math.isnan(value):
        return "nan"
    return value if isinstance(value, str | int | float) else list(value)


def test_every_node_of_a_session_has_a_table():
    assert set(BY_NODE) == set(NODES)
    started = session_nodes(SessionOptions("s", Path("s"), execute=True, console=True, markers=True))
    assert {spec.executable for spec in started} <= set(BY_NODE)


@pytest.mark.parametrize("spec", SPECS)
def test_a_default_is_a_value_the_parameter_takes(spec: ParameterSpec):
    assert plain(spec.checked(spec.default)) == plain(spec.default)
    assert spec.description.endswith((".", ")"))
    assert spec.range is None or spec.range[0] < spec.range[1]


@pytest.mark.parametrize("table", TABLES, ids=BY_NODE)
def test_a_derived_default_is_the_one_of_the_table_where_all_else_is_default(table: ParameterTable):
    assert len(set(table.names)) == len(table.names)
    assert {n: plain(v) for n, v in table.values().items()} == {s.name: plain(s.default) for s in table.specs}


@pytest.mark.parametrize("name", NODES)
def test_a_node_has_the_parameters_of_its_table_and_no_others(name: str, make: Callable[..., TableNode]):
    node, table = make(name), BY_NODE[name]
    own = {n: p.value for n, p in node.get_parameters_by_prefix("").items()}
    ours = {n: v for n, v in own.items() if n not in ROS_NAMES and not n.startswith("qos_overrides.")}
    assert set(ours) == set(table.names)
    for spec in table.specs:
        about: ParameterDescriptor = node.describe_parameter(spec.name)
        if spec.name not in ("bag", "folder", "min_free"):  # given above
            # A list of no texts is [''] to ROS, which takes an empty one for a list of bytes.
            assert plain(ours[spec.name]) == (plain(spec.default) if spec.default != () else [""])
            assert plain(node.values[spec.name]) == plain(spec.default)
        assert about.read_only == spec.read_only
        assert about.description.startswith(spec.description)
        ranges = [(r.from_value, r.to_value) for r in (*about.integer_range, *about.floating_point_range)]
        assert ranges == ([] if spec.range is None else [spec.range])


@pytest.mark.parametrize("name", NODES)
def test_every_node_refuses_a_misspelt_name_with_the_nearest(name: str, make: Callable[..., TableNode]):
    right = BY_NODE[name].names[0]
    wrong = f"{right[0]}{right[2]}{right[1]}{right[3:]}"
    with pytest.raises(ParameterError, match=f"{name} has no parameter '{wrong}'; did you mean '{right}'"):
        make(name, **{wrong: 1})


@pytest.mark.parametrize("name", ["perception", "mapping", "recorder", "cell"])
def test_a_node_refuses_a_value_out_of_range_with_the_range(name: str, make: Callable[..., TableNode]):
    spec = next(s for s in BY_NODE[name].specs if s.range is not None)
    assert spec.range is not None
    beyond = type(spec.default)(spec.range[1] + 1)
    with pytest.raises(ParameterError, match=f"parameter {spec.name} is .*, {re.escape(spec.allowed)}"):
        make(name, **{spec.name: beyond})


def test_ros_s_own_parameters_are_taken(make: Callable[..., TableNode]):
    node = make("markers", use_sim_time=True, **{"qos_overrides./clock.subscription.depth": 3})
    assert node.get_parameter("use_sim_time").value is True


@pytest.mark.parametrize("strategy", ["mbd", "evidence"])
def test_the_mapping_s_threshold_is_the_strategy_s_own_unless_given(strategy: str, make: Callable[..., TableNode]):
    own = make("mapping", strategy=strategy).get_parameter("threshold").value
    assert own == {"mbd": 0.02, "evidence": 0.7}[strategy]
    assert make("mapping", strategy=strategy, threshold=0.5).get_parameter("threshold").value == 0.5


COMMANDS = {
    "console": ("mbd_console.ros.main", ["-p", "prot:=8181"], "console has no parameter 'prot'; did you mean 'port'?"),
    "perception": (
        "mbd_perception.ros.node",
        ["--params-file", "FILE"],
        "perception has no parameter 'camera_positoin'; did you mean 'camera_position'?",
    ),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_process_ends_with_one_line_and_code_1(name: str, ros_domain: int, tmp_path: Path):
    module, words, refusal = COMMANDS[name]
    file = tmp_path / "camera.yaml"
    file.write_text("/**:\n  ros__parameters:\n    camera_positoin: [0.5, 0.0, 1.0]\n")
    command = [sys.executable, "-m", module, "--ros-args", *(w.replace("FILE", str(file)) for w in words)]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(ros_domain)}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        output, _ = process.communicate(timeout=60.0)
    finally:
        process.send_signal(signal.SIGKILL)
    assert process.returncode == 1
    lines = [line for line in output.splitlines() if line.strip()]
    assert len(lines) == 1, output
    assert lines[0].endswith(refusal)


@pytest.mark.parametrize("simulated", [True, False])
def test_what_a_session_gives_its_nodes_is_in_their_tables(simulated: bool):
    options = SessionOptions("s", Path("s"), simulated=simulated, execute=True, console=True, markers=True)
    for spec in session_nodes(options):
        table = BY_NODE[spec.executable]
        table.values({n: v for n, v in spec.parameters.items() if n not in ROS_NAMES})
        for package, file in spec.config:
            assert table.in_file(SRC / package / "config" / file)


@pytest.mark.parametrize("bag", sorted(p.parent for p in (ROOT / "bags").glob("*/metadata.yaml")), ids=lambda p: p.name)
def test_the_parameters_of_an_old_bag_are_read_by_today_s_names(bag: Path):
    facts = Bag(bag).facts
    for table in TABLES:
        recorded = parameters_of(facts, table.node)
        if recorded:
            # "bag" is a folder of the machine, which no bag contains.
            assert set(table.names) - set(table.recorded(recorded)) <= {"bag"} | LATER, table.node


def test_the_page_of_topics_shows_the_parameters_that_the_nodes_declare():
    page = (ROOT / "docs" / "topics.md").read_text(encoding="utf-8")
    assert page == with_parameters(page), "run: tools/parameters_table --write"
    assert all(len(line) <= 120 for line in parameter_page().splitlines())


def test_a_misspelt_launch_argument_is_refused_with_the_nearest():
    refuse_unknown(["ros2", "launch", "mbd_bringup", "session.launch.py", *(f"{name}:=1" for name in ARGUMENTS)])
    with pytest.raises(MbdError, match=r"no launch argument 'sede'; did you mean 'seed'\?"):
        refuse_unknown(["ros2", "launch", "mbd_bringup", "session.launch.py", "sede:=3"])
    with pytest.raises(MbdError, match=r"no launch argument 'xyz'; there are: session, folder"):
        refuse_unknown(["session.launch.py", "xyz:=3"])
