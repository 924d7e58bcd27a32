"""Tool poses and joint states read straight from their bytes (CDR): in a tenth of the time that messages take."""

from __future__ import annotations

import struct

from geometry_msgs.msg import PoseStamped
from mbd_model.ros.conversions import time_from_msg
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

HEAD = struct.Struct("<iII")  # stamp [s, ns], length of frame_id with its closing zero
POSE = struct.Struct("<7d")
COUNT = struct.Struct("<I")
BODY = 4  # bytes before the message itself; places are aligned from there
LITTLE_ENDIAN = 1

PoseValues = tuple[float, str, tuple[float, float, float], tuple[float, float, float, float]]


def _aligned(at: int, size: int) -> int:
    return at + (BODY - at) % size


def pose_from_bytes(data: bytes) -> PoseValues:
    """(stamp [s], frame_id, position x, y, z [m], quaternion x, y, z, w) of a serialized PoseStamped."""
    if data[1] != LITTLE_ENDIAN:
        msg: PoseStamped = deserialize_message(data, PoseStamped)
        p, o = msg.pose.position, msg.pose.orientation
        return time_from_msg(msg.header.stamp), msg.header.frame_id, (p.x, p.y, p.z), (o.x, o.y, o.z, o.w)
    sec, nanosec, length = HEAD.unpack_from(data, BODY)
    end = BODY + HEAD.size + length
    frame = data[BODY + HEAD.size : end - 1].decode()
    x, y, z, qx, qy, qz, qw = POSE.unpack_from(data, _aligned(end, 8))
    return sec + 1e-9 * nanosec, frame, (x, y, z), (qx, qy, qz, qw)


class JointStateReader:
    """Reads serialized JointStates; the names, which hardly change, once."""

    def __init__(self) -> None:
        self._known: dict[bytes, tuple[str, ...]] = {}
        self._last = b"\xff"

    def read(self, data: bytes) -> tuple[float, tuple[str, ...], tuple[float, ...]]:
        """(stamp [s], names, positions) of one."""
        if data[1] != LITTLE_ENDIAN:
            msg: JointState = deserialize_message(data, JointState)
            return time_from_msg(msg.header.stamp), tuple(msg.name), tuple(msg.position)
        sec, nanosec, length = HEAD.unpack_from(data, BODY)
        begin = _aligned(BODY + HEAD.size + length, 4)
        if not data.startswith(self._last, begin):
            self._last = self._names(data, begin)
        at = _aligned(begin + len(self._last), 4)
        (count,) = COUNT.unpack_from(data, at)
        positions = struct.unpack_from(f"<{count}d", data, _aligned(at + 4, 8)) if count else ()
        return sec + 1e-9 * nanosec, self._known[self._last], positions

    def _names(self, data: bytes, begin: int) -> bytes:
        """The bytes of the names from ``begin`` on, which are then known."""
        (count,) = COUNT.unpack_from(data, begin)
        at, names = begin + 4, []
        for _ in range(count):
            at = _aligned(at, 4)
            (length,) = COUNT.unpack_from(data, at)
            names.append(data[at + 4 : at + 3 + length].decode())
            at += 4 + length
        block = data[begin:at]
        self._known[block] = tuple(names)
        return block
