"""Which of the topics that are there a recorder takes, and by which quality of service."""

from __future__ import annotations

import re

from rclpy.node import Node

from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import IMAGE
from mbd_bag.images.image_compression import SUFFIXES
from mbd_bag.recorder.parameters import RecorderConfig
from mbd_bag.ros.qos_profiles import topic_qos
from mbd_bag.storage.topic_qos import TopicQos, wanted_qos

CLOUD = "sensor_msgs/msg/PointCloud2"
IMAGES_AND_INFO = (IMAGE, "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo")
LARGE = (CLOUD, *IMAGES_AND_INFO)

# Kept for a recorder that gets no processor time for a while [messages]: many of what is small, 3 s of pictures.
DEPTH, LARGE_DEPTH = 4000, 100


class TopicChoice:
    """Asks ROS's graph; what is left out for no wish of the operator is said once.

    Args:
        node: of the recorder.
        config: of the recorder.

    Raises:
        BagError: a pattern of topics to exclude cannot be read.
    """

    def __init__(self, node: Node, config: RecorderConfig) -> None:
        try:
            self._exclude = [re.compile(pattern) for pattern in config.exclude]
        except re.error as error:
            raise BagError(f"parameter exclude: {error}") from error
        self._node, self._config = node, config
        self._skipped: set[str] = set()

    def left_out(self, topic: str, msgtype: str) -> bool:
        """Whether a topic is not recorded, or not in this form."""
        if any(pattern.fullmatch(topic) for pattern in self._exclude):
            return True
        # Events of services are described by no message definition of their own.
        if "/msg/" not in msgtype:
            self.skip_once(topic, f"it is of the kind '{msgtype}', and messages only are recorded")
            return True
        if msgtype == CLOUD:
            return not self._config.clouds
        # A camera driver that compresses itself is taken at its word.
        compressed = self._config.images == "compressed" and msgtype == IMAGE
        return compressed and any(self._node.count_publishers(topic + suffix) for suffix in SUFFIXES)

    def skip_once(self, topic: str, why: str) -> None:
        """Say, the first time, that a topic is not recorded."""
        if topic not in self._skipped:
            self._skipped.add(topic)
            self._node.get_logger().warning(f"topic {topic} is not recorded: {why}")

    def offers(self, topic: str) -> tuple[TopicQos, ...]:
        """What its publishers offer, each once."""
        offers = (topic_qos(e.qos_profile) for e in self._node.get_publishers_info_by_topic(topic))
        return tuple(dict.fromkeys(offers))

    def wanted(self, topic: str, msgtype: str) -> TopicQos | None:
        """What to ask of a topic, by what is offered and what others ask; None while nobody has it."""
        own = self._node.get_name(), self._node.get_namespace()
        publishers = self.offers(topic)
        subscribers = tuple(
            topic_qos(e.qos_profile)
            for e in self._node.get_subscriptions_info_by_topic(topic)
            if (e.node_name, e.node_namespace) != own
        )
        if not publishers and not subscribers:
            return None
        return wanted_qos(publishers, subscribers, LARGE_DEPTH if msgtype in LARGE else DEPTH)
