"""A node's command line: what ROS makes of it, and nothing besides."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError

from mbd_model.errors import MbdError

HOW = "parameters are given as: --ros-args -p name:=value"


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


def init_ros(**options: Any) -> None:
    """``rclpy.init`` with the command line's words for ROS.

    Args:
        options: of ``rclpy.init``.

    Raises:
        CommandLineError: ROS does not understand them, or cannot read a file that they name.
    """
    try:
        rclpy.init(**options)
    except (UnknownROSArgsError, RCLError) as error:
        # Where in ROS's own sources it was noticed is of no use to who wrote the command.
        what = re.sub(r", at /[^,]*", "", str(error)).strip()
        raise CommandLineError(f"ROS cannot use the command line: {what}; {HOW}") from error
