"""What the camera saw when a scene was observed, and through which camera, from the bag."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mbd_study.bag import Bag
from mbd_study.errors import BagError
from mbd_study.mcap_file import BagMessage
from mbd_study.projection import CameraView
from mbd_study.session_facts import parameters_of

Picture = NDArray[np.uint8]
# How long before a scene was published its frame may have been recorded [ns].
_LOOK_BACK = 20_000_000_000
# Which bytes of a pixel are red, green and blue.
_CHANNELS = {"rgb8": (3, [0, 1, 2]), "bgr8": (3, [2, 1, 0]), "rgba8": (4, [0, 1, 2]), "bgra8": (4, [2, 1, 0])}


def topic_ending(bag: Bag, suffix: str, msgtype: str) -> str | None:
    """The bag's topic of that type whose name ends so; None when there is none (or no message on it)."""
    names = [t.name for t in bag.topics if t.name.endswith(f"/{suffix}") and t.msgtype == msgtype and t.count]
    return names[0] if names else None


def _stamp(message: BagMessage) -> int:
    """Stamp of a message that starts with a Header [ns], without decoding the rest of it."""
    order = "<" if message.data[1] else ">"
    seconds, nanoseconds = struct.unpack_from(f"{order}iI", message.data, 4)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def image_at(bag: Bag, stamp: int, log_time: int, suffix: str = "camera/color/image_raw") -> Picture | None:
    """The colour picture closest to an observation, (height, width, 3) RGB; None when the bag has none near it.

    Args:
        bag: to look in.
        stamp: of the scene [ns].
        log_time: of the scene [ns].
        suffix: last words of the topic's name.

    Raises:
        BagError: the picture's encoding is not one of rgb8, bgr8, rgba8, bgra8, mono8.
    """
    topic = topic_ending(bag, suffix, "sensor_msgs/msg/Image")
    if topic is None:
        return None
    best: BagMessage | None = None
    for message in bag.messages({topic}, log_time - _LOOK_BACK, log_time + 1):
        if best is None or abs(_stamp(message) - stamp) < abs(_stamp(best) - stamp):
            best = message
    return None if best is None else _pixels(bag.decoder.decode(best), topic)


def _pixels(image: object, topic: str) -> Picture:
    encoding, height, width = (
        str(getattr(image, "encoding", "")),
        getattr(image, "height", 0),
        getattr(image, "width", 0),
    )
    rows = np.frombuffer(getattr(image, "data", b""), np.uint8).reshape(height, -1)
    if encoding == "mono8":
        return np.repeat(rows[:, :width, None], 3, axis=2)
    if encoding not in _CHANNELS:
        raise BagError(f"pictures on {topic} are '{encoding}'; expected one of {[*_CHANNELS, 'mono8']}")
    size, order = _CHANNELS[encoding]
    return rows[:, : size * width].reshape(height, width, size)[:, :, order]


def camera_of(bag: Bag) -> CameraView | None:
    """The camera as camera_info and perception's recorded parameters tell it; None when either is not in the bag."""
    topic = topic_ending(bag, "camera/color/camera_info", "sensor_msgs/msg/CameraInfo")
    parameters = parameters_of(bag.facts, "perception")
    if topic is None or not {"camera_position", "camera_orientation"} <= set(parameters):
        return None
    if parameters.get("camera_pose") == "table":
        return None  # perception placed the scene in a frame of its own, under a camera nobody surveyed
    _, info = next(bag.decoded({topic}))
    k: Sequence[float] = info.k
    return CameraView.from_parameters(
        (k[0], k[4], k[2], k[5]),
        (int(info.width), int(info.height)),
        parameters["camera_position"],
        parameters["camera_orientation"],
    )
