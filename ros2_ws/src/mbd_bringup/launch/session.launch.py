"""One study session: the nodes, and in simulation the cell with its scripted teacher and wizard.

ros2 launch mbd_bringup session.launch.py task:=sorting seed:=3
ros2 launch mbd_bringup session.launch.py simulated:=false session:=p07_sorting participant:=p07
"""

import os
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from mbd_bringup.nodes import SessionOptions, session_nodes

ARGUMENTS = {
    "session": ("session", "name of the session and folder of its bag"),
    "folder": ("sessions", "folder that takes the sessions' folders"),
    "task": ("sorting", "stacking, sorting, lunch_packing, dish_sorting or assembly"),
    "seed": ("1", "of every random choice in the simulated cell"),
    "strategy": ("mbd", "of the mapping: mbd or evidence"),
    "threshold": ("", "confidence from which the robot goes on alone; empty: the strategy's own (mbd: 0.02)"),
    "simulated": ("true", "false expects a real robot and camera"),
    "speed": ("1.0", "simulated over real time; 0 is as fast as possible"),
    "participant": ("", "who teaches, for the bag"),
    "carry_on": ("false", "true: the robot carries the task out on the target objects"),
    "scripted_wizard": ("true", "false: a person answers, by topics or console; in simulation only"),
    "console": ("false", "true: start the operator's web page, http://127.0.0.1:8080"),
    "markers": ("true", "publish the session as markers for RViz and Foxglove"),
}


def nodes(context):
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}

    def yes(name):
        if value[name].lower() not in ("true", "false"):
            raise ValueError(f"{name}:={value[name]} is neither true nor false")
        return value[name].lower() == "true"

    options = SessionOptions(
        session=value["session"],
        folder=(Path(value["folder"]) / value["session"]).resolve(),
        task=value["task"],
        seed=int(value["seed"]),
        strategy=value["strategy"],
        threshold=float(value["threshold"]) if value["threshold"] else None,
        simulated=yes("simulated"),
        speed=float(value["speed"]),
        participant=value["participant"],
        carry_on=yes("carry_on"),
        scripted_wizard=yes("scripted_wizard"),
        console=yes("console"),
        markers=yes("markers"),
    )
    actions = []
    for spec in session_nodes(options):
        parameters = [spec.parameters]
        if spec.config is not None:
            package, file = spec.config
            parameters.insert(0, str(Path(get_package_share_directory(package)) / "config" / file))
        actions.append(
            Node(
                package=spec.package,
                executable=spec.executable,
                parameters=parameters,
                output="screen",
                # A node that dies comes back: it finds its inputs and its kept state again.
                respawn=spec.executable not in ("cell", "wizard"),
                respawn_delay=1.0,
            )
        )
    return actions


def generate_launch_description():
    profile = str(Path(get_package_share_directory("mbd_bringup")) / "config" / "fastdds_profile.xml")
    declared = [DeclareLaunchArgument(name, default_value=d, description=text) for name, (d, text) in ARGUMENTS.items()]
    environment = [
        SetEnvironmentVariable(
            "FASTRTPS_DEFAULT_PROFILES_FILE", os.environ.get("FASTRTPS_DEFAULT_PROFILES_FILE", profile)
        ),
        SetEnvironmentVariable("MUJOCO_GL", os.environ.get("MUJOCO_GL", "osmesa")),
    ]
    return LaunchDescription([*declared, *environment, OpaqueFunction(function=nodes)])
