"""What is true of a complete session, kept in its bag: who, which task, which software, which parameters.

Facts are flat texts by key, as MCAP metadata and rosbag2's custom_data want them: ``session``, ``participant``,
``task``, ``seed``, ``version.<package>``, ``platform``, ``parameter.<node>.<name>``, ``fingerprint``. Parameter values
are written as in a ROS parameters file. Nothing reveals on which machine a session was recorded.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import yaml
from mbd_model.parameters import ParameterError, ParameterTable

from mbd_bag.errors import BagError
from mbd_bag.formats.bounded_yaml import bounded_yaml

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


# What differs from session to session although the set-up is the same.
_OF_ONE_SESSION = frozenset(
    {"session", "participant", "task", "seed", "state_dir", "room_dir", "bag", "start_type_description_service"}
)


def fingerprint(facts: Mapping[str, str]) -> str:
    """16 hex digits that are equal for sessions of one set-up: versions, platform and parameters of every node.

    The recorder's own parameters and those that name the session do not count; neither does any name of a machine.
    """
    counted = sorted(
        (key, text)
        for key, text in facts.items()
        if key.startswith(("version.", "platform", "parameter."))
        and not key.startswith("parameter./recorder.")
        and key.rpartition(".")[2] not in _OF_ONE_SESSION
    )
    return hashlib.sha256("\n".join(f"{k}={v}" for k, v in counted).encode()).hexdigest()[:16]


def as_text(value: Any) -> str:
    """A parameter's value as a ROS parameters file has it."""
    text: str = yaml.safe_dump(value, default_flow_style=True, width=1_000_000)
    return text.removesuffix("\n").removesuffix("\n...")


def package_versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """``version.<package>`` of those installed here and of Python, and the platform they run on."""
    facts = {"version.python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
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
                values[name] = bounded_yaml(text)
            except ValueError as error:
                raise BagError(f"recorded parameter {name} of node {owner} is no YAML value: {text!r}") from error
    return values


def recorded_parameters(facts: Mapping[str, str], table: ParameterTable) -> dict[str, Any]:
    """A node's recorded parameters as today's version takes them, by today's names; {} when none were recorded.

    Args:
        facts: of the session.
        table: of the node.

    Raises:
        BagError: a recorded value is no YAML, or none that the parameter takes.
    """
    try:
        return table.recorded(parameters_of(facts, table.node))
    except ParameterError as error:
        raise BagError(f"of the recorded parameters of node {table.node} one cannot be used: {error}") from error
