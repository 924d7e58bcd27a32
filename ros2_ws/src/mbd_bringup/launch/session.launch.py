"""One study session: the nodes, and in simulation the cell with its scripted teacher and wizard.

ros2 launch mbd_bringup session.launch.py task:=sorting seed:=3
ros2 launch mbd_bringup session.launch.py simulated:=false session:=p07_sorting participant:=p07
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from mbd_bringup.launch_arguments import ARGUMENTS, given_in, options_of, refuse_unknown
from mbd_bringup.nodes import NodeSpec, session_nodes
from mbd_bringup.robot_settings import Parameter
from mbd_bringup.ros.known_tasks import refuse_unknown_task
from mbd_bringup.transport import VARIABLE, profile_variables


def config(package: str, file: str) -> str:
    return file if not package else str(Path(get_package_share_directory(package)) / "config" / file)


def typed(value: Parameter) -> Parameter | ParameterValue:
    # A word that looks like a number ("07" of a participant) must stay a word.
    return ParameterValue(value, value_type=str) if isinstance(value, str) else value


def without_cell(event: ProcessExited, _context: LaunchContext) -> Shutdown | None:
    # Killed or interrupted it comes back. A scene that it refuses it would refuse again, and without it is no session.
    return Shutdown(reason="the cell could not go on") if event.returncode > 0 else None


def action(spec: NodeSpec, environment: Mapping[str, str]) -> Node:
    # A node that dies comes back: it finds its inputs and its kept state again.
    return Node(
        package=spec.package,
        executable=spec.executable,
        parameters=[
            *(config(package, file) for package, file in spec.config),
            {name: typed(value) for name, value in spec.parameters.items()},
        ],
        additional_env=profile_variables(environment, shared_memory=spec.shared_memory) or None,
        output="screen",
        respawn=True,
        respawn_delay=1.0,
        on_exit=without_cell if spec.executable == "cell" else None,
        # Asked again soon; then time for the recorder to write what it holds.
        sigterm_timeout="3",
        sigkill_timeout="37",
    )


def nodes(context: LaunchContext) -> list[Node]:
    # Where another launch file includes this one, the command line is that file's.
    own = any(Path(word).name == Path(__file__).name for word in sys.argv)
    if own:
        refuse_unknown(sys.argv)
    words = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    options = options_of(words, given_in(sys.argv) if own else None)
    refuse_unknown_task(options)
    return [action(spec, context.environment) for spec in session_nodes(options)]


def generate_launch_description() -> LaunchDescription:
    profile = os.environ.get(VARIABLE) or config("mbd_bringup", "fastdds_profile.xml")
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(n, default_value=a.default, description=a.description)
                for n, a in ARGUMENTS.items()
            ),
            SetEnvironmentVariable(VARIABLE, profile),
            OpaqueFunction(function=nodes),
        ]
    )
