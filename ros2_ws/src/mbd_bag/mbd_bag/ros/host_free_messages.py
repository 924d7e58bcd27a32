"""Logs and parameter events as a bag takes them: without the folders of the machine they come from."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message

from mbd_bag.ros.parameter_collector import host_free

LOG, PARAMETER_EVENT = "rcl_interfaces/msg/Log", "rcl_interfaces/msg/ParameterEvent"
_PATH = re.compile(r"(?<![\w.:/])/(?P<first>[\w.+@-]+)/(?:[\w.+@-]+/)*(?P<last>[\w.+@-]*)")


def host_free_text(text: str) -> str:
    """A text with the last name in place of each path whose first folder is one of this machine.

    A topic's name looks like a path; its first word is no folder at the root.
    """

    def shorter(match: re.Match[str]) -> str:
        return match["last"] if Path("/", match["first"]).is_dir() else match[0]

    return _PATH.sub(shorter, text)


def host_free_bytes(data: bytes, msgtype: str) -> bytes:
    """A serialized message without such folders; of other types than these two as it is.

    Args:
        data: CDR bytes.
        msgtype: LOG, PARAMETER_EVENT, or any other.
    """
    if msgtype == LOG:
        log: Any = deserialize_message(bytes(data), Log)
        log.msg, log.file = host_free_text(log.msg), Path(log.file).name
        return bytes(serialize_message(log))
    if msgtype == PARAMETER_EVENT:
        event: Any = deserialize_message(bytes(data), ParameterEvent)
        for parameter in (*event.new_parameters, *event.changed_parameters, *event.deleted_parameters):
            parameter.value.string_value = host_free(parameter.value.string_value)
        return bytes(serialize_message(event))
    return bytes(data)
