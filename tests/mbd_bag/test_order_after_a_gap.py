"""What was said while no recorder was there comes before what is said when one is back, though the clock stands."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from mbd_bag.ros.recorder_node import Recorder
from mbd_bag.spool.reconciliation import GRACE
from mbd_bag.spool.spool_file import SpooledMessage, SpoolWriter, spool_path
from mbd_bag.storage.bag import Bag
from mbd_model.ros.conversions import stamp_to_msg, state_to_msg
from mbd_model.ros.qos import LATCHED
from mbd_model.session import Phase, SessionState
from mbd_msgs import msg as m
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

WORD, NUMBER, STATE = "/interaction/word", "/mapping/number", "/interaction/state"
STANDS = 7_000_000_000  # [ns] what the session's clock says all the time


def state(phase: Phase) -> m.SessionState:
    return state_to_msg(SessionState("gap", phase), 1.0)


class Gap:
    """A recorder that finds in the journal what was said before it began, and somebody who speaks."""

    def __init__(self, folder: Path, domain: int, said: list[tuple[str, str, Any]]) -> None:
        journal = SpoolWriter(spool_path(folder / "spool", "1a"))
        for number, (topic, kind, message) in enumerate(said):
            now = time.time_ns()
            journal.append(SpooledMessage(topic, kind, now, 100 + number, now, STANDS, serialize_message(message)))
        journal.close()
        self.bag, self.context = folder / "bag", rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.speaker = Node("speaker", context=self.context)
        self._clock = self.speaker.create_publisher(Clock, "/clock", 10)
        values: dict[str, Any] = {"bag": str(self.bag), "spool": str(folder / "spool"), "run": "1a"}
        values |= {"use_sim_time": True, "end_with_session": True}
        parameters = [Parameter(k, value=v) for k, v in values.items()]
        self.begun = time.monotonic()
        self.recorder = Recorder(context=self.context, parameter_overrides=parameters)
        self._executor = SingleThreadedExecutor(context=self.context)
        for node in (self.recorder, self.speaker):
            self._executor.add_node(node)
        self.until(lambda: self.recorder.get_clock().now().nanoseconds == STANDS)

    def until(self, condition: Callable[[], bool]) -> None:
        """Spin until it is so."""
        deadline = time.monotonic() + 60.0
        while not condition():
            self._clock.publish(Clock(clock=stamp_to_msg(STANDS)))
            self._executor.spin_once(timeout_sec=0.05)
            assert time.monotonic() < deadline, "waited in vain"

    def says(self, topic: str, message: Any) -> None:
        """Publish it on a latched topic, until the recorder has it."""
        counts = self.recorder.recording.counts
        self._out = self.speaker.create_publisher(type(message), topic, LATCHED)
        self._out.publish(message)
        self.until(lambda: topic in counts and counts[topic].received > 0)

    def read(self, topic: str, kind: type) -> list[Any]:
        """What the bag holds of a topic."""
        return [deserialize_message(b.data, kind) for b in Bag(self.bag).messages() if b.topic == topic]


@pytest.fixture
def gap(ros_domain: int, tmp_path: Path) -> Iterator[Callable[[list[tuple[str, str, Any]]], Gap]]:
    made: list[Gap] = []

    def make(said: list[tuple[str, str, Any]]) -> Gap:
        made.append(Gap(tmp_path, ros_domain, said))
        return made[-1]

    yield make
    for each in made:
        rclpy.try_shutdown(context=each.context)


def test_what_fell_into_the_gap_is_read_before_what_a_latched_topic_states_again(gap):
    there = gap([(WORD, "std_msgs/msg/String", String(data=word)) for word in ("first", "second", "third")])
    there.says(WORD, String(data="fourth"))
    there.recorder.close()
    assert [s.data for s in there.read(WORD, String)] == ["first", "second", "third", "fourth"]


def test_a_phase_of_before_that_is_taken_in_later_does_not_undo_the_session_s_end(gap):
    assist = [(STATE, "mbd_msgs/msg/SessionState", state(Phase.ASSIST))]
    there = gap([*assist, (NUMBER, "std_msgs/msg/String", String(data="0.98"))])
    # The end arrives by itself a moment before what is older is taken in.
    there.until(lambda: time.monotonic() - there.begun > GRACE - 1.0)
    there.says(STATE, state(Phase.DONE))

    def closed() -> bool:
        there.recorder.close_after_session()
        return not there.recorder.recording.open

    there.until(closed)
    assert [s.phase for s in there.read(STATE, m.SessionState)] == [Phase.ASSIST, Phase.DONE]
    assert [s.data for s in there.read(NUMBER, String)] == ["0.98"]
