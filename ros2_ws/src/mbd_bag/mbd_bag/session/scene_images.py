"""What the camera saw when a scene was observed, and through which camera, from the bag."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mbd_model.camera.view import CameraView
from numpy.typing import NDArray

from mbd_bag.errors import BagError
from mbd_bag.formats.contents import BagMessage
from mbd_bag.images.image_cdr import COMPRESSED_IMAGE, IMAGE, RawImage, read_image
from mbd_bag.images.image_compression import SUFFIXES, decompress
from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.session.session_facts import parameters_of
from mbd_bag.storage.bag import Bag

Picture = NDArray[np.uint8]
# How long before a scene was published its frame may have been recorded [ns].
_LOOK_BACK = 20_000_000_000
# Which bytes of a pixel are red, green and blue.
_CHANNELS = {"rgb8": (3, [0, 1, 2]), "bgr8": (3, [2, 1, 0]), "rgba8": (4, [0, 1, 2]), "bgra8": (4, [2, 1, 0])}


def topic_ending(bag: Bag, suffix: str, msgtype: str) -> str | None:
    """The bag's topic of that type whose name ends so; None when there is none (or no message on it)."""
    names = [t.name for t in bag.topics if t.name.endswith(f"/{suffix}") and t.msgtype == msgtype and t.count]
    return names[0] if names else None


def image_topic(bag: Bag, suffix: str) -> str | None:
    """The topic that holds the pictures published on one with this ending, raw or compressed; None when none does."""
    raw = topic_ending(bag, suffix, IMAGE)
    compressed = (topic_ending(bag, suffix + more, COMPRESSED_IMAGE) for more in SUFFIXES)
    return raw or next((name for name in compressed if name is not None), None)


def raw_image(message: BagMessage) -> RawImage:
    """The picture of a recorded message, compressed or not; raises BagError."""
    return decompress(message.data) if message.msgtype == COMPRESSED_IMAGE else read_image(message.data)


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
    topic = image_topic(bag, suffix)
    if topic is None:
        return None
    best: BagMessage | None = None
    for message in bag.messages({topic}, log_time - _LOOK_BACK, log_time + 1):
        if best is None or abs(header_stamp(message.data) - stamp) < abs(header_stamp(best.data) - stamp):
            best = message
    return None if best is None else color_pixels(raw_image(best), topic)


def color_pixels(image: RawImage, topic: str) -> Picture:
    """(height, width, 3) RGB; raises BagError for an encoding that is no colour."""
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, -1)
    if image.encoding == "mono8":
        return np.repeat(rows[:, : image.width, None], 3, axis=2)
    if image.encoding not in _CHANNELS:
        raise BagError(f"pictures on {topic} are '{image.encoding}'; expected one of {[*_CHANNELS, 'mono8']}")
    size, order = _CHANNELS[image.encoding]
    return rows[:, : size * image.width].reshape(image.height, image.width, size)[:, :, order]


def camera_of(bag: Bag) -> CameraView | None:
    """The camera as camera_info and perception's recorded parameters give it; None when either is not in the bag."""
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
