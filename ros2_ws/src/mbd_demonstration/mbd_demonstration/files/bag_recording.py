"""A rosbag as the columns of a recording: poses and joints by their stamps, in the order they were recorded."""

from __future__ import annotations

import sqlite3
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbd_demonstration.clocks.stamps import checked
from mbd_demonstration.hand.fingers import FINGER_NAME, named_fingers
from mbd_demonstration.recording_files import RecordedColumns, RecordingFileError, columns_of

Floats = NDArray[np.float64]
POSE, JOINTS = "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/JointState"
COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
# Before the first pose and after the last one, by more than this [s], where the tool was is not recorded.
BEYOND = 1.0
# What rosbags raises on bytes that are not what they should be.
_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, RecursionError, RuntimeError),
    *(TypeError, ValueError, struct.error, sqlite3.Error),
)


def read_bag(path: Path, fingers: tuple[str, ...] = ()) -> RecordedColumns:
    """One topic of tool poses (PoseStamped) and one of joint states, at the stamps of the finger that has most.

    Args:
        path: of the bag's folder, or of a file in it.
        fingers: joints of the gripper; empty: found by their names.

    Raises:
        RecordingFileError: it cannot be read, or has no tool poses or finger joints.
    """
    folder = path if path.is_dir() else path.parent
    rows, joints = _messages(folder, fingers)
    used = named_fingers(tuple(joints), fingers)
    if not used or not rows:
        lacking = "tool poses (PoseStamped)" if not rows else f"finger joints (named like {FINGER_NAME.pattern})"
        raise RecordingFileError(f"the bag {folder} has no {lacking}")
    poses, notes = _in_time(rows, "the tool poses")
    tracks = {}
    for name in used:
        tracks[name], about = _in_time(joints[name], f"'{name}'")
        notes += about
    if not poses.size or not all(track.size for track in tracks.values()):
        raise RecordingFileError(f"the bag {folder} has no stamps that can be used; {'; '.join(notes)}")
    base = max(tracks.values(), key=len)[:, 0]
    moved = {name: np.interp(base, track[:, 0], track[:, 1]) for name, track in tracks.items()}
    outside = (base < poses[0, 0] - BEYOND) | (base > poses[-1, 0] + BEYOND)
    along = {name: np.interp(base, poses[:, 0], poses[:, k + 1]) for k, name in enumerate(COLUMNS)}
    along = {name: np.where(outside, np.nan, values) for name, values in along.items()}
    return columns_of({"t": base, **along}, moved, folder, notes)


def _messages(
    folder: Path, fingers: tuple[str, ...]
) -> tuple[list[tuple[float, ...]], dict[str, list[tuple[float, ...]]]]:
    """(rows of poses, rows of each finger joint): time of recording [s], stamp [s], and the values."""
    from rosbags.highlevel import AnyReader, AnyReaderError
    from rosbags.rosbag2 import ReaderError
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_typestore
    from ruamel.yaml.error import YAMLError

    rows: list[tuple[float, ...]] = []
    joints: dict[str, list[tuple[float, ...]]] = {}
    try:
        with AnyReader([folder], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as bag:
            wanted = [
                c for c in bag.connections if c.msgtype in (POSE, JOINTS) and not c.topic.endswith("/in/tool_pose")
            ]
            for connection, recorded, data in bag.messages(connections=wanted):
                message: Any = bag.deserialize(data, connection.msgtype)
                at = (1e-9 * recorded, message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)
                if connection.msgtype == POSE:
                    p, q = message.pose.position, message.pose.orientation
                    rows.append((*at, p.x, p.y, p.z, q.x, q.y, q.z, q.w))
                elif len(message.position) == len(message.name):
                    for name in named_fingers(tuple(message.name), fingers):
                        joints.setdefault(name, []).append((*at, message.position[message.name.index(name)]))
    except (OSError, AnyReaderError, ReaderError, SerdeError, TypesysError, YAMLError, *_DAMAGE) as error:
        words = " ".join(str(error).split())[:200] or type(error).__name__
        raise RecordingFileError(f"cannot read the bag {folder}: {words}") from error
    return rows, joints


def _in_time(rows: list[tuple[float, ...]], what: str) -> tuple[Floats, tuple[str, ...]]:
    """(rows (n, 1 + d): stamps [s], mended where that is certain, in order, and values; what was noticed)."""
    table = np.array(rows)
    dated = checked(table[:, 1], what, table[:, 0])
    found = np.column_stack([dated.stamps, table[:, 2:]])[np.isfinite(dated.stamps)]
    return found[np.argsort(found[:, 0], kind="stable")], dated.notes
