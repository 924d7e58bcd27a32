"""Between builtin_interfaces/Time and float seconds, and between Time and integer nanoseconds.

A float holds simulated time to 1 ns and today's wall-clock time to 0.24 us. So when something was is in seconds
(``time_...``), and a stamp by which an input is known again is in nanoseconds (``stamp_...``), which are exact.
"""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.clock import Clock
from std_msgs.msg import Header

from mbd_model.times import to_nanoseconds, to_seconds


def time_to_msg(at: float) -> Time:
    """Seconds since the epoch (or start of simulation) as a Time."""
    return stamp_to_msg(to_nanoseconds(at))


def time_from_msg(stamp: Time) -> float:
    """A Time as float seconds."""
    return to_seconds(stamp_from_msg(stamp))


def stamp_to_msg(stamp: int) -> Time:
    """Integer nanoseconds as a Time."""
    seconds, rest = divmod(stamp, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)


def stamp_from_msg(stamp: Time) -> int:
    """A Time, of rclpy or as rosbags decodes it, as integer nanoseconds."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def clock_seconds(clock: Clock) -> float:
    """A clock's time as float seconds."""
    return to_seconds(clock.now().nanoseconds)


def header(stamp: float, frame_id: str = "") -> Header:
    """A header of that time [s] and frame."""
    return Header(stamp=time_to_msg(stamp), frame_id=frame_id)
