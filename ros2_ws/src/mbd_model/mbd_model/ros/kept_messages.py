"""Messages kept in a state folder, also by a version whose definitions lacked the fields that were added since.

A file holds a message's CDR bytes and nothing of its definition. Fields are only ever added at the end, so what an
older version kept is the beginning of what today's would keep of the same message.
"""

from __future__ import annotations

from typing import TypeVar

from mbd_msgs.msg import Progress, SessionState, Task
from rclpy.serialization import deserialize_message, serialize_message

Message = TypeVar("Message")

# The fields added since 0.1.0, the multiple of bytes they begin at, and how many they take when they hold defaults.
_ADDED: dict[type, tuple[tuple[str, ...], int, int]] = {
    SessionState: (("recording", "awaiting"), 1, 2),
    Progress: (("purpose", "object_id", "receiver_id"), 1, 17),
    Task: (("open_ends",), 4, 4),
}


def kept_message(data: bytes, msg_type: type[Message]) -> Message:
    """The message a file holds; fields that the version which kept it did not have get ROS's defaults.

    Args:
        data: CDR bytes, with their header.
        msg_type: message class.

    Raises:
        RuntimeError: no such message; what rclpy's C layer raises.
    """
    try:
        return deserialize_message(data, msg_type)
    except RuntimeError:
        if msg_type not in _ADDED:
            raise
        fields, alignment, size = _ADDED[msg_type]
        gap = -len(data) % alignment
        message, same = (deserialize_message(data + bytes([fill]) * gap + bytes(64), msg_type) for fill in (0, 1))
        default = msg_type()
        # A file cut off anywhere else is no message of an older version: its values would reach into what was appended.
        # Bytes are not compared, as padding is arbitrary.
        complete = message == same and len(serialize_message(message)) == len(data) + gap + size
        if not complete or any(getattr(message, name) != getattr(default, name) for name in fields):
            raise
        return message
