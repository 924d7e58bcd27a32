"""What was said while no recorder was there comes before what is said when one is back, though the clock stands."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from mbd_bag.ros.recorder_node import Recorder
from mbd_bag.spool.spool_file import SpooledMessage, SpoolWriter, spool_path
from mbd_bag.storage.bag import Bag
from mbd_model.ros.conversions import stamp_to_msg
from mbd_model.ros.qos import LATCHED
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

TOPIC = "/interaction/word"
STANDS = 7_000_000_000  # [ns] what the session's clock said last; nobody says it again


def test_what_fell_into_the_gap_is_read_before_what_a_latched_topic_states_again(ros_domain: int, tmp_path: Path):
    journal = SpoolWriter(spool_path(tmp_path / "spool", "1a"))
    for number, word in enumerate(("first", "second", "third")):
        data = serialize_message(String(data=word))
        now = time.time_ns()
        journal.append(SpooledMessage(TOPIC, "std_msgs/msg/String", now, 100 + number, now, STANDS, data))
    journal.close()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    speaker = Node("speaker", context=context)
    words, clock = speaker.create_publisher(String, TOPIC, LATCHED), speaker.create_publisher(Clock, "/clock", 10)
    values = {"bag": str(tmp_path / "bag"), "spool": str(tmp_path / "spool"), "run": "1a", "use_sim_time": True}
    recorder = Recorder(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in values.items()])
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(recorder)
    executor.add_node(speaker)
    counts = recorder.recording.counts
    deadline = time.monotonic() + 60.0

    def until(condition: Callable[[], bool]) -> None:
        while not condition():
            clock.publish(Clock(clock=stamp_to_msg(STANDS)))
            executor.spin_once(timeout_sec=0.05)
            assert time.monotonic() < deadline, "waited in vain"

    until(lambda: recorder.get_clock().now().nanoseconds == STANDS)
    words.publish(String(data="fourth"))
    until(lambda: TOPIC in counts and counts[TOPIC].received > 0)
    recorder.close()
    rclpy.shutdown(context=context)
    read = [deserialize_message(m.data, String).data for m in Bag(tmp_path / "bag").messages() if m.topic == TOPIC]
    assert read == ["first", "second", "third", "fourth"]
