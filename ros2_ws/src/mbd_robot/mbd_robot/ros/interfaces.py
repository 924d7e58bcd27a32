"""Interfaces of other packages: used where they are installed, named where they are missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from mbd_model.errors import MbdError

WHERE = {
    "control_msgs": "apt install ros-jazzy-control-msgs",
    "controller_manager_msgs": "apt install ros-jazzy-controller-manager-msgs",
    "example_interfaces": "apt install ros-jazzy-example-interfaces",
    "franka_msgs": "build franka_ros2 and source its workspace",
    "kinova_msgs": "build the Kinova driver and source its workspace",
    "moveit_msgs": "apt install ros-jazzy-moveit-msgs",
    "shape_msgs": "apt install ros-jazzy-shape-msgs",
    "tf2_msgs": "apt install ros-jazzy-tf2-msgs",
    "ur_dashboard_msgs": "apt install ros-jazzy-ur-dashboard-msgs",
}


def interface(package: str, kind: str, name: str) -> Any:
    """A message, service or action type of another package.

    Args:
        package: such as control_msgs.
        kind: msg, srv or action.
        name: of the type.

    Raises:
        MbdError: the package is not installed, or has no such type.
    """
    try:
        return getattr(import_module(f"{package}.{kind}"), name)
    except ImportError as error:
        how = WHERE.get(package, f"install {package}")
        raise MbdError(f"this robot needs {package}/{kind}/{name}, and {package} is not installed; {how}") from error
    except AttributeError as error:
        raise MbdError(f"{package} has no {kind} {name}; is it of another release of ROS?") from error
