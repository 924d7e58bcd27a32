"""Record every topic of a session to one bag.

Run: ``./mbd run mbd_bag recorder --ros-args -p bag:=bags/sorting_1 -p task:=sorting -p seed:=1``
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import replace
from importlib import import_module
from typing import Any

import rclpy
from mbd_model.ros.leaving import leave
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.run_node import START_FAILURES, explained
from mbd_model.ros.signals import StopRequest
from mbd_model.ros.starting.command_line import init_ros, refuse_other_words
from mbd_model.ros.starting.node_help import answer_help
from mbd_model.session import Phase
from mbd_msgs.msg import SessionState
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from mbd_bag.errors import BagError
from mbd_bag.recorder.parameters import RECORDER, RUN, recorder_config
from mbd_bag.recorder.session_recording import SessionRecording
from mbd_bag.recorder.session_span import STATE
from mbd_bag.recorder.thinning import Thinning
from mbd_bag.recorder.topic_counts import TopicCount
from mbd_bag.ros.host_free_messages import host_free_bytes
from mbd_bag.ros.message_sink import MessageSink
from mbd_bag.ros.missed_messages import MissedMessages
from mbd_bag.ros.parameter_collector import ParameterCollector
from mbd_bag.ros.qos_profiles import asked_profile
from mbd_bag.ros.raw_subscription import subscribe_raw
from mbd_bag.ros.recorder_report import RecorderReport
from mbd_bag.ros.topic_choice import DEPTH, IMAGES_AND_INFO, LARGE, LARGE_DEPTH, TopicChoice
from mbd_bag.session.session_facts import package_versions, parameter_facts
from mbd_bag.spool.parameters import is_spooled
from mbd_bag.spool.spool_file import Key, SpooledMessage
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.definitions import full_definition, type_hash
from mbd_bag.storage.topic_qos import TopicQos

_LARGE_NAMES = {name.rpartition("/")[2] for name in LARGE}

# Once asked to stop, take what still arrives until it is quiet for this long, but no longer than that [s].
_DRAIN_QUIET, _DRAIN_LIMIT = 0.1, 2.0
_CATCH_UP = 0.5  # [s] between two looks at what was spooled
# Looks for new topics from one look at all of them to the next: another publisher may have come in the place of one.
_ALL_AGAIN = 10


class Recorder(TableNode):
    """Subscribes to whatever topic appears, as its publishers offer it, and hands the raw bytes to the writing thread.

    Raises:
        BagError: a parameter or the bag's place cannot be used.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(RECORDER, **options)
        config = recorder_config(self.values)
        self._choice = TopicChoice(self, config)
        self._config = config
        # The log is recorded too, and a bag states no folder of the machine.
        self.recording = SessionRecording(config, self.get_logger().warning, self.get_logger().info)
        facts = {"session": config.session or self.recording.output.writer.folder.name}
        facts |= {"participant": config.participant, "task": config.task, "seed": str(config.seed)}
        # By the wall clock, also in simulation: of two sessions it states which was held first.
        facts |= {RUN: config.run, "begun": str(time.time_ns()), **package_versions()}
        # Not where the bag lies: a bag states nothing of the machine it was recorded on.
        own = {name: parameter.value for name, parameter in sorted(self.get_parameters_by_prefix("").items())}
        del own["bag"], own["plan"], own["spool"]
        self.recording.add_facts(facts | parameter_facts(self.get_fully_qualified_name(), own))
        self._taken: dict[str, tuple[TopicQos, Subscription[object]]] = {}
        self._records: dict[str, tuple[TopicRecord, str]] = {}  # with their definitions
        self._publisher_counts: dict[str, int] = {}
        self._there: dict[str, tuple[int, int]] = {}  # how many publish and subscribe, when last asked what they offer
        self._looks = 0
        self._missed: MissedMessages | None = None
        self._phase_since = 0  # [ns] when the state was published that the phase in force is of
        if config.spool:
            counts = {file.name: file.counts for file in self.recording.output.writer.earlier}
            self._missed = MissedMessages(config, counts, self.get_logger().warning)
            self.recording.on_flushed = self._missed.flushed
            # What arrives by itself came after what is taken in, also while the session's clock stands.
            sim_time = bool(self.get_parameter("use_sim_time").value)
            if until := self._missed.spooled_until(sim_time=sim_time):
                self.recording.output.clock.stamp(until + 1)
            self.create_timer(_CATCH_UP, self._catch_up, clock=rclpy.clock.Clock())
        self._sink = MessageSink(self, self.recording, self._missed)
        self.received_at = -math.inf  # one that is stopped before its first message waits for no other
        self._parameters_of_others = ParameterCollector(self, self.recording.add_facts)
        self.create_timer(config.discovery_period, self._discover, clock=rclpy.clock.Clock())
        RecorderReport(self, self.recording)
        self._discover()

    def close(self) -> None:
        """Finish the bag with all that has arrived, if it is open."""
        if self.recording.open:
            self._catch_up(everything=True)
            self._sink.release()
            for topic in self._records:
                if not self.recording.output.knows(topic):
                    self._make_known(topic, ())
            self.recording.close()

    def _catch_up(self, *, everything: bool = False) -> None:
        """Write what was said while this recorder was away, or did not get through to it."""
        if self._missed is None:
            return
        self._missed.log_passed()
        if self.recording.open and (everything or not self._sink.waits_for_clock()):
            for message in self._missed.missing(everything=everything):
                self._take_in(message)

    def _take_in(self, message: SpooledMessage) -> None:
        if message.topic not in self._taken:
            self._subscribe(message.topic, [message.msgtype], TopicQos(depth=DEPTH))
            if message.topic not in self._taken:
                return
        package, kind, name = message.msgtype.split("/")
        message_class = getattr(import_module(f"{package}.{kind}"), name)
        # What was said before the phase in force is part of the session, however late it is taken in.
        late = 0 < message.source < self._phase_since
        if not late and not self._is_part(message.topic, message_class, message.data, message.source):
            self._pass_over(message.key)
            return
        if not self.recording.output.knows(message.topic):
            self._make_known(message.topic, self._choice.offers(message.topic))
        self._sink.take_in(message, self.recording.counts.setdefault(message.topic, TopicCount()))

    def _pass_over(self, key: Key | None) -> None:
        if self._missed is not None and key is not None:
            self._missed.pass_over(key)

    def close_after_session(self) -> None:
        """Close the bag when its session is over and nobody said a word for a while."""
        if self.recording.over():
            self.get_logger().info("the session is over: the recording ends, and its bag is closed")
            self.close()

    def _is_part(self, topic: str, kind: type, data: bytes, source: int) -> bool:
        """Whether a message is part of the session; what states its phase, at ``source`` [ns], is looked at."""
        if kind is SessionState and topic.endswith(f"/{STATE}"):
            self._phase_since = max(self._phase_since, source)
            phase = int(deserialize_message(data, SessionState).phase)
            # What an end is stated again with, to whoever subscribes again, opens nothing.
            if phase in set(Phase) and not self.recording.enter(Phase(phase)) and not self.recording.open:
                return False
        return self.recording.takes(topic, large=kind.__name__ in _LARGE_NAMES)

    def _discover(self) -> None:
        again = self._looks % _ALL_AGAIN == 0
        self._looks += 1
        for topic, types in self.get_topic_names_and_types():
            if self._choice.left_out(topic, types[0]):
                continue
            self._publisher_counts[topic] = publishers = self.count_publishers(topic)
            # Who offers and asks what takes ten times as long to find out as how many do.
            there = publishers, self.count_subscribers(topic)
            if not again and self._there.get(topic) == there:
                continue
            self._there[topic] = there
            wanted = self._choice.wanted(topic, types[0])
            taken = self._taken.get(topic)
            if wanted is None or (taken is not None and (taken[0] == wanted or not publishers)):
                continue
            self._subscribe(topic, types, wanted)

    def _make_known(self, topic: str, offers: tuple[TopicQos, ...]) -> None:
        """Add a topic to the bag with what its publishers offer, or, when none is known, with what is asked of them.

        Not before its first message: a topic that somebody waits for may have no publisher yet, and a player of the
        bag must know that it is latched.
        """
        record, definition = self._records[topic]
        asked = replace(self._taken[topic][0], history="unknown", depth=0)
        self.recording.output.add_topic(replace(record, qos=offers or (asked,)), definition)

    def _subscribe(self, topic: str, types: list[str], qos: TopicQos) -> None:
        try:
            if len(types) != 1:
                raise BagError(f"it has several types {types}; rename one")
            record = TopicRecord(topic, types[0], type_hash(types[0])), full_definition(types[0])
            package, kind, name = types[0].split("/")
            message_class = getattr(import_module(f"{package}.{kind}"), name)
        except (BagError, ImportError, AttributeError) as error:
            self._choice.skip_once(topic, str(error))
            return
        if topic in self._taken:
            self.destroy_subscription(self._taken[topic][1])
        else:
            self._records[topic] = record
        thinned = Thinning(self._config.image_rate if types[0] in IMAGES_AND_INFO else 0.0)
        count = self.recording.counts.setdefault(topic, TopicCount())
        spooled = self._missed is not None and is_spooled(types[0], qos)

        def record_one(data: bytes, info: dict[str, int]) -> None:
            self.received_at = time.monotonic()
            key = _key(topic, info) if spooled else None
            if key is not None and self._missed is not None and not self._missed.receive(key):
                return
            if not self._is_part(topic, message_class, data, info.get("source_timestamp") or 0):
                count.pass_over()
                self._pass_over(key)
                return
            if not self.recording.output.knows(topic):
                self._make_known(topic, self._choice.offers(topic))
            count.receive(info.get("publication_sequence_number"), alone=self._publisher_counts.get(topic) == 1)
            if not thinned.keeps(data):
                return
            if types[0] in LARGE and not self.recording.budget.keeps(count.received):
                count.left_out += 1
            else:
                picture = qos.depth == LARGE_DEPTH
                self._sink.take(topic, host_free_bytes(data, types[0]), info, count, key, picture=picture)

        self._taken[topic] = (qos, subscribe_raw(self, message_class, topic, record_one, asked_profile(qos)))


def _key(topic: str, info: dict[str, int]) -> Key:
    return topic, info.get("source_timestamp") or 0, info.get("publication_sequence_number") or 0


def _record(recorder: Recorder, stop: StopRequest) -> None:
    """Record until SIGINT or SIGTERM, then take what has arrived already."""
    executor = SingleThreadedExecutor()
    executor.add_node(recorder)
    while not stop and recorder.recording.failure is None:
        executor.spin_once(timeout_sec=0.1)
        recorder.close_after_session()
    deadline = time.monotonic() + _DRAIN_LIMIT
    while recorder.recording.open and time.monotonic() < min(deadline, recorder.received_at + _DRAIN_QUIET):
        executor.spin_once(timeout_sec=0.05)


def main() -> None:
    """Run the node; exit code 0 when the bag is closed and complete, 1 otherwise."""
    # Our own handlers only: rclpy's shut the context down, and with it what still waits in its queues. A terminal's
    # Ctrl-C may come twice, and must not break off the closing of the bag.
    stop = StopRequest()
    try:
        answer_help("recorder", Recorder)
        refuse_other_words()
        init_ros(signal_handler_options=SignalHandlerOptions.NO)
        if stop:
            rclpy.try_shutdown()
            return
        recorder = Recorder()
    except START_FAILURES as error:
        sys.stderr.write(f"recorder: {explained(error)}\n")
        rclpy.try_shutdown()
        raise SystemExit(1) from None
    try:
        _record(recorder, stop)
    except ExternalShutdownException:
        pass
    finally:
        recorder.close()
        leave(recorder)
    raise SystemExit(1 if recorder.recording.failed else 0)
