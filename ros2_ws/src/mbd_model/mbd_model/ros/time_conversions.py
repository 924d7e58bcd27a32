"""Between float seconds and builtin_interfaces/Time.

A float holds simulated time to 1 ns and today's wall-clock time to 0.24 us: stamps that identify an input stay Times.
"""

from __future__ import annotations

from builtin_interfaces.msg import Time
from std_msgs.msg import Header


def time_to_msg(seconds: float) -> Time:
    """Seconds since the epoch (or start of simulation) as a Time."""
    nanoseconds = round(seconds * 1e9)
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def time_from_msg(stamp: Time) -> float:
    """A Time as float seconds."""
    return (int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)) / 1e9


def header(stamp: float, frame_id: str = "") -> Header:
    """A header of that time [s] and frame."""
    return Header(stamp=time_to_msg(stamp), frame_id=frame_id)
