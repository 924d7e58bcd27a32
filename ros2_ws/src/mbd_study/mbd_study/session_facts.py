"""What is true of a whole session, kept in its bag: who, which task, which software, which parameters.

Facts are flat texts by key, as MCAP metadata and rosbag2's custom_data want them: ``session``, ``participant``,
``task``, ``seed``, ``version.<package>``, ``parameter.<node>.<name>``. Parameter values are written as in a ROS
parameters file.
"""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import yaml

from mbd_study.errors import BagError

PACKAGES = (
    "mbd_model",
    "mbd_perception",
    "mbd_demonstration",
    "mbd_mapping",
    "mbd_interaction",
    "mbd_cell",
    "mbd_study",
    "mbd_bringup",
    "rclpy",
    "numpy",
    "scipy",
    "opencv-python-headless",
    "mujoco",
    "mcap",
)


def as_text(value: Any) -> str:
    """A parameter's value as a ROS parameters file has it."""
    text: str = yaml.safe_dump(value, default_flow_style=True, width=1_000_000)
    return text.removesuffix("\n").removesuffix("\n...")


def package_versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """``version.<package>`` of those installed here, and of Python."""
    facts = {"version.python": platform.python_version()}
    for package in packages:
        try:
            facts[f"version.{package}"] = version(package)
        except PackageNotFoundError:
            continue
    return facts


def parameter_facts(node: str, values: Mapping[str, Any]) -> dict[str, str]:
    """Facts of one node's parameters.

    Args:
        node: its full name, ``/mapping``.
        values: by parameter name.
    """
    return {f"parameter.{node}.{name}": as_text(value) for name, value in values.items()}


def parameters_of(facts: Mapping[str, str], node: str) -> dict[str, Any]:
    """A node's recorded parameters by name; {} when none were recorded.

    Args:
        facts: of the session.
        node: its name without namespace.

    Raises:
        BagError: a recorded value is no YAML.
    """
    values: dict[str, Any] = {}
    for key, text in facts.items():
        kind, _, rest = key.partition(".")
        owner, _, name = rest.partition(".")
        if kind == "parameter" and owner.rpartition("/")[2] == node:
            try:
                values[name] = yaml.safe_load(text)
            except yaml.YAMLError as error:
                raise BagError(f"recorded parameter {name} of node {owner} is no YAML value: {text!r}") from error
    return values
