"""From a message that arrived to the bag: with its times, and held while simulated time has not begun."""

from __future__ import annotations

import time

from rclpy.node import Node

from mbd_bag.recorder.held_messages import HeldMessages
from mbd_bag.recorder.session_recording import SessionRecording
from mbd_bag.recorder.topic_counts import TopicCount
from mbd_bag.ros.host_free_messages import host_free_bytes
from mbd_bag.ros.missed_messages import MissedMessages
from mbd_bag.spool.spool_file import Key, SpooledMessage


class MessageSink:
    """Hands messages of known topics on to be written.

    Args:
        node: by whose clock they are stamped.
        recording: that takes them.
        missed: learns what is written; None where nothing is spooled.
    """

    def __init__(self, node: Node, recording: SessionRecording, missed: MissedMessages | None) -> None:
        self._node, self._recording, self._missed = node, recording, missed
        self._held = HeldMessages()
        self._sim_time = bool(node.get_parameter("use_sim_time").value)
        self._earlier_end = recording.output.writer.last_log_time

    def take(
        self, topic: str, data: bytes, info: dict[str, int], count: TopicCount, key: Key | None, *, picture: bool
    ) -> None:
        """Take a message that has just arrived.

        Args:
            topic: it came on.
            data: its CDR bytes.
            info: what the middleware states of it.
            count: of its topic.
            key: that names it; None where it is of no topic that is spooled.
            picture: whether it may be left out.
        """
        if self.waits_for_clock():

            def write() -> None:
                self._put(topic, data, self._times(info), key, count)

            count.left_out += not self._held.hold(write, len(data), picture=picture)
            return
        self.release()
        self._put(topic, data, self._times(info), key, count)

    def take_in(self, message: SpooledMessage, count: TopicCount) -> None:
        """Take a message that only the journal has."""
        count.recover()
        # When it was said, but never before what an earlier file of the bag holds: files are read one by one.
        log_time = max(message.session_time if self._sim_time else message.received, self._earlier_end)
        published = log_time if self._sim_time else message.source or log_time
        data = host_free_bytes(message.data, message.msgtype)
        self._put(message.topic, data, (log_time, published), message.key, count)

    def waits_for_clock(self) -> bool:
        """Whether simulated time has not begun."""
        return (
            self._sim_time
            and not self._recording.output.clock.latest
            and not self._node.get_clock().now().nanoseconds
        )  # fmt: skip

    def release(self) -> None:
        """Write what was held; by the machine's clock when no other ever told the time."""
        if self._held and self.waits_for_clock():
            self._recording.output.clock.stamp(time.time_ns())
        self._held.release()

    def _put(self, topic: str, data: bytes, times: tuple[int, int], key: Key | None, count: TopicCount) -> None:
        missed = self._missed

        def written() -> None:
            count.written += 1
            if missed is not None and key is not None:
                missed.written(key)

        log_time, published = times
        self._recording.output.write(topic, log_time, data, published, written)

    def _times(self, info: dict[str, int]) -> tuple[int, int]:
        """Log time and publish time of a message [ns]."""
        clock = self._recording.output.clock
        if self._sim_time:
            log_time = clock.stamp(self._node.get_clock().now().nanoseconds)
            return log_time, log_time
        log_time = clock.stamp(info["received_timestamp"] or time.time_ns())
        return log_time, info["source_timestamp"] or log_time
