"""A recorder finds out who publishes what, and asks no more of ROS's graph for it than it must."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from mbd_bag.ros.recorder_node import Recorder
from mbd_model.ros.qos import EVENTS, LATCHED
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import String

WORD = "/interaction/word"


class CountedRecorder(Recorder):
    """One that counts its looks, and how often it asked who publishes a topic, whose number tells nothing."""

    def __init__(self, **options: Any) -> None:
        self.looks, self.asked = 0, Counter[str]()
        super().__init__(**options)

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        self.looks += 1
        return super().get_topic_names_and_types(no_demangle)

    def count_publishers(self, topic_name: str) -> int:
        # While one takes the place of another there may be two for a moment, or none: that is not what is tried here.
        return 1 if topic_name == WORD else super().count_publishers(topic_name)

    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[Any]:
        self.asked[topic_name] += 1
        return super().get_publishers_info_by_topic(topic_name, no_mangle)


class Looking:
    """A recorder that looks a hundred times a second, and a node beside it."""

    def __init__(self, folder: Path, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.speaker = Node("speaker", context=self.context)
        values = {"bag": str(folder / "bag"), "discovery_period": 0.01, "min_free": 1.0}
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.recorder = CountedRecorder(context=self.context, parameter_overrides=overrides)
        self._executor = SingleThreadedExecutor(context=self.context)
        for node in (self.recorder, self.speaker):
            self._executor.add_node(node)

    def until(self, condition: Callable[[], bool]) -> None:
        """Spin until it is so."""
        deadline = time.monotonic() + 60.0
        while not condition():
            self._executor.spin_once(timeout_sec=0.05)
            assert time.monotonic() < deadline, "waited in vain"

    def look(self, times: int) -> None:
        """Spin until it has looked so often more."""
        until = self.recorder.looks + times
        self.until(lambda: self.recorder.looks >= until)

    def durability(self) -> DurabilityPolicy | None:
        """What the recorder asks of the topic; None while it does not record it."""
        asked = [
            e.qos_profile.durability
            for e in self.speaker.get_subscriptions_info_by_topic(WORD)
            if e.node_name == self.recorder.get_name()
        ]
        return asked[0] if len(asked) == 1 else None

    def close(self) -> None:
        self.recorder.close()
        self._executor.shutdown()
        for node in (self.recorder, self.speaker):
            node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def looking(ros_domain: int, tmp_path: Path) -> Iterator[Looking]:
    made = Looking(tmp_path, ros_domain)
    yield made
    made.close()


def test_where_a_publisher_takes_the_place_of_another_the_recorder_asks_for_what_the_new_one_offers(looking: Looking):
    first = looking.speaker.create_publisher(String, WORD, EVENTS)
    looking.until(lambda: looking.durability() is DurabilityPolicy.VOLATILE)
    looking.look(3)
    looking.speaker.create_publisher(String, WORD, LATCHED)
    looking.speaker.destroy_publisher(first)
    looking.until(lambda: looking.durability() is DurabilityPolicy.TRANSIENT_LOCAL)


def test_while_nobody_comes_or_goes_it_asks_who_publishes_at_one_look_of_ten(looking: Looking):
    looking.speaker.create_publisher(String, WORD, EVENTS)
    looking.until(lambda: looking.durability() is not None)
    looking.look(20)
    looking.recorder.asked.clear()
    looking.look(20)
    assert set(looking.recorder.asked) >= {WORD}
    assert max(looking.recorder.asked.values()) <= 3
