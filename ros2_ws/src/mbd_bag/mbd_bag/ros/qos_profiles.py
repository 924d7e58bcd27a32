"""Between a topic's quality of service as a bag has it and rclpy's profiles."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from mbd_bag.storage.topic_qos import TopicQos

_DEPTH = 100  # messages a replay keeps for whoever is slow, where the bag does not state how many
# Over the network no publisher reports its history; rosbag2 writes that down as unknown, too.
_HISTORIES = {HistoryPolicy.KEEP_ALL: "keep_all", HistoryPolicy.KEEP_LAST: "keep_last"}


def topic_qos(profile: QoSProfile) -> TopicQos:
    """What the graph states of a publisher or subscriber."""
    return TopicQos(
        reliability="best_effort" if profile.reliability == ReliabilityPolicy.BEST_EFFORT else "reliable",
        durability="transient_local" if profile.durability == DurabilityPolicy.TRANSIENT_LOCAL else "volatile",
        history=_HISTORIES.get(profile.history, "unknown"),
        depth=profile.depth,
    )


def asked_profile(qos: TopicQos) -> QoSProfile:
    """With which a recorder subscribes: its own depth, whatever the publishers' is."""
    return _profile(qos, HistoryPolicy.KEEP_LAST, qos.depth)


def offered_profile(qos: TopicQos) -> QoSProfile:
    """With which a replay publishes. Of an unknown history: the latest latched fact, of all else enough for bursts."""
    if qos.history == "keep_all":
        return _profile(qos, HistoryPolicy.KEEP_ALL, 0)
    usual = 1 if qos.durability == "transient_local" else _DEPTH
    return _profile(qos, HistoryPolicy.KEEP_LAST, qos.depth or usual)


def _profile(qos: TopicQos, history: HistoryPolicy, depth: int) -> QoSProfile:
    return QoSProfile(
        history=history,
        depth=depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )
