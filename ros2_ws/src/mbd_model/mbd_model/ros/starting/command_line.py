"""A node's command line: what ROS makes of it, and nothing besides."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import rclpy
import yaml
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError

from mbd_model.errors import MbdError
from mbd_model.ros.starting.loopback import wait_for_loopback

HOW = "parameters are given as: --ros-args -p name:=value"
FILE = "expected as in: {/**: {ros__parameters: {name: value}}}"


class CommandLineError(MbdError):
    """Words that a node's process was started with and that mean nothing to it."""


def other_words(words: Sequence[str]) -> list[str]:
    """The words that are not for ROS: those outside of ``--ros-args ... --``.

    So also ``name:=value`` there, which rclpy's own ``remove_ros_args`` takes for a remapping as ROS 1 wrote them.
    """
    others, for_ros = [], False
    for word in words:
        if word == "--ros-args":
            for_ros = True
        elif for_ros and word == "--":
            for_ros = False
        elif not for_ros:
            others.append(word)
    return others


def refuse_other_words() -> None:
    """Raises CommandLineError when this process was given words besides those for ROS: they would do nothing."""
    others = other_words(sys.argv[1:])
    if others:
        raise CommandLineError(f"'{others[0]}' on the command line means nothing here; {HOW}")


def parameter_files(words: Sequence[str]) -> list[Path]:
    """The files that these words give by ``--params-file``."""
    found, for_ros, before = [], False, ""
    for word in words:
        for_ros = word == "--ros-args" or (for_ros and word != "--")
        if for_ros and before == "--params-file":
            found.append(Path(word))
        before = word
    return found


def refuse_parameter_file(path: Path) -> None:
    """Refuse a file that ROS would read no parameter from, or of which it says only which token it did not expect.

    Raises:
        CommandLineError: it cannot be read, is no YAML, or has no section with ``ros__parameters``.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CommandLineError(f"the parameter file {path} cannot be read: {error.strerror}; {FILE}") from error
    except (UnicodeDecodeError, yaml.YAMLError, RecursionError) as error:
        why = " ".join(str(error).split())
        raise CommandLineError(f"the parameter file {path} is no YAML: {why}; {FILE}") from error
    if not _has_parameters(content):
        raise CommandLineError(f"the parameter file {path} has no section of parameters; {FILE}")


def _has_parameters(content: object, depth: int = 4) -> bool:
    """Whether there is a key ``ros__parameters``, below the name of a node and of namespaces perhaps."""
    if not isinstance(content, dict) or not depth:
        return False
    return "ros__parameters" in content or any(_has_parameters(inner, depth - 1) for inner in content.values())


def init_ros(**options: Any) -> None:
    """``rclpy.init`` with the command line's words for ROS.

    Args:
        options: of ``rclpy.init``.

    Raises:
        CommandLineError: ROS does not understand them, or cannot read a file that they name.
        MbdError: this machine's own address is not there.
    """
    for path in parameter_files(sys.argv[1:]):
        refuse_parameter_file(path)
    wait_for_loopback()
    try:
        rclpy.init(**options)
    except (UnknownROSArgsError, RCLError) as error:
        # Where in ROS's own sources it was noticed is of no use to who wrote the command.
        what = re.sub(r", at /[^,]*", "", str(error)).strip()
        raise CommandLineError(f"ROS cannot use the command line: {what}; {HOW}") from error
