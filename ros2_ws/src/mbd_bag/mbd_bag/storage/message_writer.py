"""Write message objects, not yet serialized, to a bag: for sessions that come from elsewhere than a live recorder."""

from __future__ import annotations

import array
from types import SimpleNamespace
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.topic_qos import TopicQos

LATCHED = TopicQos(durability="transient_local", depth=1)
EVENTS = TopicQos(history="keep_all", depth=0)
SENSOR = TopicQos(reliability="best_effort", depth=5)


def message_type(message: Any) -> str:
    """``package/msg/Type`` of a generated message."""
    module = type(message).__module__.split(".")
    return f"{module[0]}/{module[1]}/{type(message).__name__}"


def _with_numpy(value: Any) -> Any:
    """The same fields with arrays of numbers as numpy arrays, as rosbags wants them."""
    if isinstance(value, array.array):
        return np.frombuffer(value, dtype=value.typecode) if len(value) else np.empty(0, dtype=value.typecode)
    if isinstance(value, list):
        return [_with_numpy(v) for v in value]
    if hasattr(value, "get_fields_and_field_types"):
        return SimpleNamespace(
            **{name: _with_numpy(getattr(value, name)) for name in value.get_fields_and_field_types()}
        )
    return value


class MessageWriter:
    """Serializes messages into a bag by the installed definitions, without a ROS graph.

    Args:
        bag: to write to; the caller closes it.
    """

    def __init__(self, bag: BagWriter) -> None:
        self.bag = bag
        self._store = get_typestore(Stores.EMPTY)
        self._known: set[str] = set()

    def encode(self, message: Any) -> bytes:
        """CDR bytes of a generated message."""
        kind = message_type(message)
        if kind not in self._known:
            self._known.add(kind)
            self._store.register(get_types_from_msg(full_definition(kind), kind))
        return bytes(self._store.serialize_cdr(_with_numpy(message), kind))

    def write(self, topic: str, message: Any, log_time: int, qos: TopicQos = LATCHED) -> None:
        """Add one message.

        Args:
            topic: absolute name.
            message: a generated message.
            log_time: when it was (or would have been) received [ns].
            qos: that its publisher would offer.
        """
        kind = message_type(message)
        data = self.encode(message)
        self.bag.add_topic(TopicRecord(topic, kind, type_hash(kind), (qos,)), full_definition(kind))
        self.bag.write(topic, log_time, data)
