"""Publish a recorded session live, so that nodes can be run again on it with other parameters."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any, TypeVar

from mbd_model.objects import Role
from mbd_model.ros.conversions import stamp_to_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.patient_call import call_within
from mbd_model.session import Phase
from mbd_msgs.msg import WizardDemonstration
from mbd_msgs.srv import Observe
from rclpy.client import Client
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger

from mbd_bag.errors import BagError
from mbd_bag.formats.contents import BagMessage
from mbd_bag.images.image_compression import decompress_message
from mbd_bag.replay.parameters import REPLAY
from mbd_bag.replay.playback import Playback
from mbd_bag.replay.replay_options import ReplayOptions
from mbd_bag.replay.replay_plan import PublishedTopic, facts_before, phase_times
from mbd_bag.ros.qos_profiles import offered_profile
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.definitions import full_definition
from mbd_bag.storage.topic_qos import TopicQos
from mbd_bag.storage.upgrading import upgraded_bytes

RequestT = TypeVar("RequestT")
AnswerT = TypeVar("AnswerT", Observe.Response, SetBool.Response, Trigger.Response)

TICK = 0.005  # [s] between looks at what is due
_PATIENCE = 60.0  # [s] for the answer of a node that runs again
_OBSERVE_AHEAD = 1_000_000_000  # [ns] by which perception is asked before the frames its scene was made of


class ReplayNode(TableNode):
    """Services replay/{pause, step, next_phase}; parameters rate, loop, paused."""

    def __init__(self, bag: Bag, session: RecordedSession, options: ReplayOptions, **kwargs: Any) -> None:
        given = {"rate": options.rate, "loop": options.loop, "paused": options.paused}
        super().__init__(REPLAY, defaults=given, **kwargs)
        self._options = options
        self.begin = options.begin
        self._limit: int | None = None
        self._phases: Sequence[tuple[Phase, int]] = phase_times(session)
        self._bag = bag
        self._topics = {t.recorded: t for t in options.topics}
        self._publish = {t.recorded: self._publisher(t) for t in options.topics}
        latched = {t for t in self._topics if any(q.durability == "transient_local" for q in bag.offered_qos(t))}
        events = {t for t in self._topics if t.split("/")[-2:-1] == ["wizard"]}
        self.playback = Playback(
            lambda start: bag.messages(set(self._topics), start=start),
            options.begin,
            bag.end,
            rate=self.values["rate"],
            loop=self.values["loop"],
            is_step=lambda message: message.topic in latched | events,
        )
        self.playback.paused = self.values["paused"]
        self._facts = facts_before(bag, set(self._topics), options.begin)
        own_clock = all(t.name != "/clock" for t in options.topics)
        self._clock_out = self.create_publisher(Clock, "/clock", 10) if own_clock else None
        self._requests = self._observations(session)
        self.add_post_set_parameters_callback(self._on_parameters)
        self.create_service(SetBool, "replay/pause", self._on_pause)
        self.create_service(Trigger, "replay/step", self._on_step)
        self.create_service(Trigger, "replay/next_phase", self._on_next_phase)

    def _on_parameters(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name in REPLAY.names:
                setattr(self.playback, parameter.name, parameter.value)

    def _publisher(self, topic: PublishedTopic) -> Callable[[bytes], None]:
        """What publishes the bytes of a recorded topic; raises BagError when its type is not installed."""
        try:
            package, kind, name = topic.msgtype.split("/")
            message_class = getattr(import_module(f"{package}.{kind}"), name)
        except (ImportError, AttributeError, ValueError) as error:
            raise BagError(f"topic {topic.name} is '{topic.msgtype}', which is not installed: {error}") from error
        offered = self._bag.offered_qos(topic.recorded)
        publisher = self.create_publisher(
            message_class, topic.name, offered_profile(offered[0] if offered else TopicQos())
        )
        if topic.decompressed:
            return lambda data: publisher.publish(decompress_message(data))
        if self._bag.decoder.texts.get(topic.msgtype, "").strip() != full_definition(topic.msgtype).strip():
            recorded = self._bag.decoder.store(topic.msgtype)
            return lambda data: publisher.publish(upgraded_bytes(data, topic.msgtype, recorded))
        return publisher.publish

    def _observations(self, session: RecordedSession) -> list[tuple[int, Callable[[], None]]]:
        """(log time, request) of each scene that perception is to see again, in order."""
        if "perception" not in self._options.without or "interaction" in self._options.without:
            return []
        client = self.create_client(Observe, "perception/observe")
        roles = {Role.SOURCE: Observe.Request.SOURCE, Role.TARGET: Observe.Request.TARGET}
        scenes = [(s, Role.SOURCE) for s in session.source_scenes] + [(s, Role.TARGET) for s in session.target_scenes]
        requests: list[tuple[int, Callable[[], None]]] = []
        for scene, role in scenes:
            request = Observe.Request(role=roles[role])
            at = min(scene.stamp, scene.log_time) - _OBSERVE_AHEAD
            if at >= self._options.begin:
                requests.append((at, partial(self._observe, client, request, scene.log_time)))
        return sorted(requests, key=lambda request: request[0])

    def _observe(self, client: Client[Observe.Request, Observe.Response], request: Observe.Request, until: int) -> None:
        """Ask perception, and play no further than where its scene came then before it has answered."""
        self._limit = until
        self._ask(client, request)

    def _ask(self, client: Client[RequestT, AnswerT], request: RequestT) -> None:
        def answered(answer: AnswerT | None) -> None:
            self._limit = None
            if answer is None:
                self.get_logger().error(f"{client.srv_name} did not answer within {_PATIENCE:.0f} s: going on without")
                return
            self.get_logger().info(f"{client.srv_name}: {'' if answer.success else 'REFUSED: '}{answer.message}")

        call_within(self, client, request, _PATIENCE, answered)

    def ready(self) -> str:
        """Which of the nodes that run again does not listen yet; "" when all do."""
        present = {name for name, _ in self.get_node_names_and_namespaces()}
        for node in self._options.without:
            if node not in present:
                return f"node {node} is not there"
            wanted = {name for name, _ in self.get_subscriber_names_and_types_by_node(node, self.get_namespace())}
            names = {t.name for t in self._options.topics}
            deaf = [name for name in wanted & names if not self.count_subscribers(name)]
            if deaf or not wanted:
                return f"node {node} does not listen yet"
        return ""

    def publish_facts(self) -> None:
        """Publish what was latched before the start."""
        for topic, log_time in self._facts.items():
            for message in self._bag.messages({topic}, log_time, log_time + 1):
                self._send(message)

    def tick(self) -> None:
        """Publish what is due."""
        for message in self.playback.due(time.monotonic(), self._limit):
            self._send(message)
        while self._requests and self._requests[0][0] <= self.playback.position:
            self._requests.pop(0)[1]()
        if self._clock_out is not None and not self.playback.paused:
            self._clock_out.publish(Clock(clock=stamp_to_msg(self.playback.position)))

    def _send(self, message: BagMessage) -> None:
        self._publish[message.topic](message.data)
        again = "demonstration" in self._options.without and "interaction" not in self._options.without
        if again and message.topic.endswith("wizard/demonstration"):
            start = self._bag.decoder.decode(message).command == WizardDemonstration.START
            client = self.create_client(Trigger, f"demonstration/{'start' if start else 'stop'}")
            self._ask(client, Trigger.Request())

    def step(self) -> int:
        """Pause, and publish up to the next fact or event; returns how many messages."""
        self.playback.paused = True
        messages = self.playback.step()
        for message in messages:
            self._send(message)
        return len(messages)

    def next_phase(self) -> str:
        """Jump to where the next phase began; returns its name, "" when there is none."""
        for phase, log_time in self._phases:
            if log_time > self.playback.position:
                self.playback.jump(log_time)
                return phase.name.lower()
        return ""

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self.playback.paused = request.data
        response.success, response.message = True, "paused" if request.data else "playing"
        return response

    def _on_step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        count = self.step()
        response.success, response.message = count > 0, f"{count} messages" if count else "the bag is at its end"
        return response

    def _on_next_phase(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        name = self.next_phase()
        response.success, response.message = bool(name), name or "there is no later phase"
        return response
