"""The definition of a type that a bag does not define itself: rosbag2 embeds them since Iron only."""

from __future__ import annotations

from functools import lru_cache

from rosbags.typesys import Stores, TypesysError, get_typestore

from mbd_bag.errors import BagError
from mbd_bag.storage.definitions import full_definition


@lru_cache(maxsize=256)
def known_definition(kind: str) -> tuple[str, str]:
    """Encoding and text of a type's definition as it is installed here, or as ROS 2 Jazzy has it; ("", "") if neither.

    Args:
        kind: ``package/msg/Type``.
    """
    try:
        return "ros2msg", full_definition(kind)
    except BagError:
        pass
    try:
        return "ros2msg", get_typestore(Stores.ROS2_JAZZY).generate_msgdef(kind, ros_version=2)[0]
    except (TypesysError, KeyError):
        return "", ""
