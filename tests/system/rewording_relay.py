"""A node between all nodes of a session: whatever one states in sentences, the others receive in other words."""

from __future__ import annotations

from typing import Any

from mbd_bringup.nodes import NodeSpec
from mbd_bringup.processes import SessionProcesses
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_msgs import msg as m
from mbd_msgs.srv import Observe
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rewording import Rewording, reworded
from std_srvs.srv import Trigger

# Every topic and service with sentences, by the node it comes from; that node has it below the namespace PLAIN.
PLAIN = "plain"
TOPICS = {
    "interaction": {
        "interaction/state": (m.SessionState, LATCHED),
        "interaction/prompt": (m.Prompt, LATCHED),
        "interaction/replies": (m.WizardReply, EVENTS),
    },
    "execution": {"interaction/progress": (m.Progress, LATCHED)},
    "demonstration": {"demonstration/task": (m.Task, LATCHED), "demonstration/recorded": (m.Task, LATCHED)},
    "mapping": {"mapping/estimate": (m.MappingEstimate, LATCHED)},
}
SERVICES = {
    "demonstration": {f"demonstration/{name}": Trigger for name in ("start", "stop", "discard")},
    "perception": {"perception/observe": Observe},
}


class RewordedProcesses(SessionProcesses):
    """Processes of which each states its sentences to the relay only."""

    def command(self, spec: NodeSpec) -> tuple[str, ...]:
        names = [*TOPICS.get(spec.executable, ()), *SERVICES.get(spec.executable, ())]
        moved = [word for name in names for word in ("-r", f"{name}:={PLAIN}/{name}")]
        return (*super().command(spec), *moved)


class RewordingRelay(Node):
    """Passes on what the processes publish, in other words; ``passed`` counts the sentences it changed, by topic."""

    def __init__(self, words: Rewording, **options: Any) -> None:
        super().__init__("rewording_relay", **options)
        self._words = words
        self.passed: dict[str, int] = {}
        for topics in TOPICS.values():
            for topic, (kind, qos) in topics.items():
                self._relay(topic, kind, qos)
        for services in SERVICES.values():
            for name, kind in services.items():
                self._serve(name, kind)

    def _relay(self, topic: str, kind: type, qos: Any) -> None:
        out = self.create_publisher(kind, topic, qos)

        def pass_on(msg: Any) -> None:
            other = reworded(msg, self._words)
            self.passed[topic] = self.passed.get(topic, 0) + (other != msg)
            out.publish(other)

        self.create_subscription(kind, f"{PLAIN}/{topic}", pass_on, qos)

    def _serve(self, name: str, kind: type) -> None:
        # The client's answer comes while the service's callback waits for it.
        group = ReentrantCallbackGroup()
        client = self.create_client(kind, f"{PLAIN}/{name}", callback_group=group)

        async def answer(request: Any, response: Any) -> Any:
            reply = await client.call_async(request)
            other = reworded(reply, self._words)
            self.passed[name] = self.passed.get(name, 0) + (other != reply)
            return other

        self.create_service(kind, name, answer, callback_group=group)
