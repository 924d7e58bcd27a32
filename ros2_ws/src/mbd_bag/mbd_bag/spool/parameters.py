"""The spool's parameters, and which topics it keeps."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_bag.storage.topic_qos import TopicQos

SPOOL = ParameterTable(
    "spool",
    (
        ParameterSpec("folder", "", "Folder of the journal; made when missing.", required=True),
        ParameterSpec("run", "", "Names one start of a session, as the recorder's does."),
        # As the recorder's; its own table would load what writes bags into a process that writes none.
        ParameterSpec("exclude", (r".*/_[^/]*(/.*)?",), "Regular expressions of complete topic names not to keep."),
        ParameterSpec("limit", 32.0, "Of one of the journal's two files.", "MB", range=(1.0, 1000.0)),
        ParameterSpec("discovery_period", 1.0, "Between looks for new topics.", "s", range=(0.01, 10.0)),
    ),
)

# Its twin: after a kill either is gone for as long as a process takes to start, and so is a recorder that was killed.
SECOND_SPOOL = replace(SPOOL, node="second_spool")
WRITERS = (SPOOL.node, SECOND_SPOOL.node)

_STREAMS = (
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/JointState",
    "rosgraph_msgs/msg/Clock",
    "tf2_msgs/msg/TFMessage",
)


def is_spooled(msgtype: str, qos: TopicQos) -> bool:
    """Whether a topic is kept: what is sent reliably, and is no stream in which the newest alone matters.

    Args:
        msgtype: ``package/msg/Type``.
        qos: that it is subscribed to with.
    """
    return msgtype not in _STREAMS and qos.reliability == "reliable"
