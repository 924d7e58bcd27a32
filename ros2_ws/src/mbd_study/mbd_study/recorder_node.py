"""Record every topic of a session to one bag.

Run: ``./mbd run mbd_study recorder --ros-args -p bag:=bags/sorting_1 -p task:=sorting -p seed:=1``
"""

from __future__ import annotations

import array
import re
import signal
import sys
import time
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import rclpy
from mbd_model.errors import MbdError
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, ParameterType
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from mbd_study.bag_metadata import TopicRecord
from mbd_study.bag_writer import BagWriter, Compression
from mbd_study.definitions import full_definition, type_hash
from mbd_study.errors import BagError
from mbd_study.log_clock import LogClock
from mbd_study.session_facts import package_versions, parameter_facts
from mbd_study.topic_qos import TopicQos, wanted_qos
from mbd_study.writing_thread import WritingThread

# Colour, depth and camera_info determine the cloud, which is five times their size. Hidden topics are actions' own.
DEFAULT_EXCLUDE = [r".*/camera/points", r".*/_[^/]*(/.*)?"]

# Once told to stop, take what still arrives until it is quiet for this long, but no longer than that [s].
_DRAIN_QUIET, _DRAIN_LIMIT = 0.2, 2.0


@dataclass(frozen=True)
class RecorderConfig:
    """Parameters of the node; each is described where it is declared."""

    bag: str
    exclude: tuple[str, ...]
    session: str
    participant: str
    task: str
    seed: int
    resume: bool
    compression: str
    min_free: float
    discovery_period: float


def _declare(node: Node) -> RecorderConfig:
    def value(name: str, default: Any, description: str, low: float | None = None, high: float = 0.0) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True)
        if low is not None:
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        if isinstance(default, list):
            descriptor.type = ParameterType.PARAMETER_STRING_ARRAY
        return node.declare_parameter(name, default, descriptor).value

    return RecorderConfig(
        bag=value("bag", "", "folder of the bag to write; it must not exist yet"),
        exclude=tuple(value("exclude", DEFAULT_EXCLUDE, "regular expressions of whole topic names not to record")),
        session=value("session", "", "name of the session; the bag's when empty"),
        participant=value("participant", "", "who teaches (a pseudonym)"),
        task=value("task", "", "name of the task"),
        seed=value("seed", 0, "seed of the simulated session"),
        resume=value("resume", False, "go on in a finished bag, in its next file"),
        compression=value("compression", "lz4", "of the bag's chunks: none, lz4 or zstd"),
        min_free=value("min_free", 500.0, "free disk space to insist on at the start [MB]", 0.0, 1e9),
        discovery_period=value("discovery_period", 0.2, "between looks for new topics [s]", 0.01, 10.0),
    )


class Recorder(Node):
    """Subscribes to whatever topic appears, as its publishers offer it, and hands the raw bytes to the writing thread.

    Raises:
        BagError: a parameter or the bag's place cannot be used.
    """

    def __init__(self) -> None:
        super().__init__("recorder")
        config = _declare(self)
        if not config.bag:
            raise BagError("no bag to write: give the parameter bag, e.g. --ros-args -p bag:=bags/sorting_1")
        try:
            self._exclude = [re.compile(pattern) for pattern in config.exclude]
            compression = Compression(config.compression)
        except (re.error, ValueError) as error:
            raise BagError(f"parameter exclude or compression: {error}") from error
        folder = Path(config.bag).expanduser().absolute()
        min_free = int(config.min_free * 1e6)
        self.writer = BagWriter(folder, compression=compression, resume=config.resume, min_free=min_free)
        self._clock_out = LogClock(self.writer.last_log_time)
        warn = self.get_logger().warning
        self.thread = WritingThread(self.writer, min_free=min_free, warn=warn)
        facts = {"session": config.session or folder.name, "participant": config.participant, "task": config.task}
        facts |= {"seed": str(config.seed), **package_versions()}
        # Not where the bag lies: a bag says nothing of the machine it was recorded on.
        own = {name: parameter.value for name, parameter in sorted(self._parameters.items()) if name != "bag"}
        self.thread.add_facts(facts | parameter_facts(self.get_fully_qualified_name(), own))
        self._taken: dict[str, tuple[TopicQos, Any]] = {}
        self._skipped: set[str] = set()
        self._waiting: dict[str, tuple[Any, Any]] = {}
        self._done_clients: list[Any] = []
        self._asked: set[str] = set()
        self.received_at = time.monotonic()
        self._sim_time = bool(self.get_parameter("use_sim_time").value)
        self.create_timer(config.discovery_period, self._discover, clock=rclpy.clock.Clock())
        self.create_timer(1.0, self._ask_parameters, clock=rclpy.clock.Clock())
        self.get_logger().info(f"recording to {self.writer.path}")
        self._discover()

    def _discover(self) -> None:
        for topic, types in self.get_topic_names_and_types():
            if any(pattern.fullmatch(topic) for pattern in self._exclude):
                continue
            own = self.get_name(), self.get_namespace()
            publishers = tuple(_topic_qos(e.qos_profile) for e in self.get_publishers_info_by_topic(topic))
            subscribers = tuple(
                _topic_qos(e.qos_profile)
                for e in self.get_subscriptions_info_by_topic(topic)
                if (e.node_name, e.node_namespace) != own
            )
            if not publishers and not subscribers:
                continue
            wanted = wanted_qos(publishers, subscribers)
            taken = self._taken.get(topic)
            if taken is not None and (taken[0] == wanted or not publishers):
                continue
            self._subscribe(topic, types, wanted, publishers)

    def _subscribe(self, topic: str, types: list[str], qos: TopicQos, offered: tuple[TopicQos, ...]) -> None:
        try:
            if len(types) != 1:
                raise BagError(f"topic {topic} is not recorded: it has several types {types}; rename one")
            record = TopicRecord(topic, types[0], type_hash(types[0]), tuple(dict.fromkeys(offered)))
            if topic not in self._taken:
                self.thread.add_topic(record, full_definition(types[0]))
            package, kind, name = types[0].split("/")
            message_class = getattr(import_module(f"{package}.{kind}"), name)
        except (BagError, ImportError, AttributeError) as error:
            if topic not in self._skipped:
                self._skipped.add(topic)
                self.get_logger().warning(f"topic {topic} is not recorded: {error}")
            return
        if topic in self._taken:
            self.destroy_subscription(self._taken[topic][1])

        def receive(data: bytes, info: Any) -> None:
            self._receive(topic, data, info)

        subscription = self.create_subscription(message_class, topic, receive, _profile(qos), raw=True)
        self._taken[topic] = (qos, subscription)

    def _receive(self, topic: str, data: bytes, info: Any) -> None:
        self.received_at = time.monotonic()
        if self._sim_time:
            log_time = published = self._clock_out.stamp(self.get_clock().now().nanoseconds)
        else:
            log_time = self._clock_out.stamp(info["received_timestamp"] or time.time_ns())
            published = info["source_timestamp"] or log_time
        self.thread.write(topic, log_time, bytes(data), published)

    def _ask_parameters(self) -> None:
        """Ask every node once for its parameters, as soon as its services are there."""
        for client in self._done_clients:
            self.destroy_client(client)
        self._done_clients.clear()
        for name, namespace in self.get_node_names_and_namespaces():
            node = f"{namespace.rstrip('/')}/{name}"
            if node not in self._asked and not name.startswith("_") and node != self.get_fully_qualified_name():
                self._asked.add(node)
                names = self.create_client(ListParameters, f"{node}/list_parameters")
                self._waiting[node] = (names, self.create_client(GetParameters, f"{node}/get_parameters"))
        for node, (names, values) in list(self._waiting.items()):
            if names.service_is_ready() and values.service_is_ready():
                del self._waiting[node]
                self._send_parameter_requests(node, names, values)

    def _send_parameter_requests(self, node: str, names: Any, values: Any) -> None:
        def on_names(future: Any) -> None:
            self._done_clients.append(names)
            request = GetParameters.Request(names=[] if future.result() is None else future.result().result.names)
            values.call_async(request).add_done_callback(lambda answer: on_values(request.names, answer))

        def on_values(asked: list[str], future: Any) -> None:
            self._done_clients.append(values)
            got = [] if future.result() is None else map(parameter_value_to_python, future.result().values)
            plain = (_host_free(v) for v in got)
            self.thread.add_facts(parameter_facts(node, dict(zip(asked, plain, strict=False))))

        names.call_async(ListParameters.Request()).add_done_callback(on_names)


def _host_free(value: Any) -> Any:
    """A parameter's value without the folders of this machine, of which a bag says nothing."""
    if isinstance(value, str) and value.startswith("/") and Path(value).exists():
        return Path(value).name
    return list(value) if isinstance(value, array.array) else value


def _topic_qos(profile: QoSProfile) -> TopicQos:
    return TopicQos(
        reliability="best_effort" if profile.reliability == ReliabilityPolicy.BEST_EFFORT else "reliable",
        durability="transient_local" if profile.durability == DurabilityPolicy.TRANSIENT_LOCAL else "volatile",
        history="keep_all" if profile.history == HistoryPolicy.KEEP_ALL else "keep_last",
        depth=profile.depth,
    )


def _profile(qos: TopicQos) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )


def _record(recorder: Recorder) -> None:
    """Record until SIGINT or SIGTERM, then take what has arrived already."""
    stopping = False

    def stop(*_: Any) -> None:
        nonlocal stopping
        stopping = True

    # Our own handlers: rclpy's shut the context down, and with it what still waits in its queues. A terminal's
    # Ctrl-C may come twice, and must not break off the closing of the bag.
    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    executor = SingleThreadedExecutor()
    executor.add_node(recorder)
    while not stopping and recorder.thread.failure is None:
        executor.spin_once(timeout_sec=0.1)
    deadline = time.monotonic() + _DRAIN_LIMIT
    while time.monotonic() < min(deadline, recorder.received_at + _DRAIN_QUIET):
        executor.spin_once(timeout_sec=0.05)


def main() -> None:
    """Run the node; exit code 0 when the bag is closed and whole, 1 otherwise."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        recorder = Recorder()
    except MbdError as error:
        sys.stderr.write(f"recorder: {error}\n")
        rclpy.try_shutdown()
        raise SystemExit(1) from None
    try:
        _record(recorder)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        failure = _close(recorder)
        rclpy.try_shutdown()
    raise SystemExit(failure)


def _close(recorder: Recorder) -> int:
    try:
        recorder.thread.close()
    except (OSError, ValueError) as error:
        sys.stderr.write(f"recorder: writing stopped: {error}. What was written is in {recorder.writer.folder}\n")
        return 1
    counts = recorder.writer.counts
    sys.stdout.write(f"recorder: {sum(counts.values())} messages on {len(counts)} topics in {recorder.writer.folder}\n")
    sys.stdout.flush()
    return 0
