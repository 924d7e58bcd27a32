"""What tests of the interaction node share: the node, and in the same process those around it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from mbd_demonstration.revision.corrections import corrected
from mbd_interaction.ros.node import InteractionNode
from mbd_interaction.synthetic import row_of_objects, stacking_task
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.ros.conversions import (
    correction_from_msg,
    scene_to_msg,
    stamp_from_msg,
    task_to_msg,
    time_to_msg,
)
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.session import Phase
from mbd_model.task import Task as DemonstratedTask
from mbd_msgs.msg import (
    Assists,
    Correspondence,
    MappingEstimate,
    Prompt,
    Scene,
    SessionState,
    Task,
    WizardAnswer,
    WizardCommand,
    WizardDemonstration,
    WizardHanded,
    WizardPointed,
    WizardReply,
    WizardRevision,
)
from mbd_msgs.srv import Observe, ReviseTask
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

# pytest's importlib mode does not put test folders on the path.
sys.path.insert(0, str(Path(__file__).parent))
from dialogue_conversation import Conversation

N = 3


class Session:
    """An interaction node and, in the same process, the nodes around it that do as they are asked."""

    def __init__(self, domain: int, state_dir: Path, *, others: bool = True, **parameters: object) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        given = {"session": "s", "state_dir": str(state_dir), "service_patience": 0.5, **parameters}
        overrides = [Parameter(k, value=v) for k, v in given.items()]
        self.node = InteractionNode(context=self.context, parameter_overrides=overrides)
        self.peer = rclpy.create_node("peer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.received: dict[str, list] = {}
        for name, kind in (("state", SessionState), ("prompt", Prompt), ("assists", Assists)):
            self.received[name] = []
            self.peer.create_subscription(kind, f"interaction/{name}", self.received[name].append, LATCHED)
        self.received["replies"] = []
        self.peer.create_subscription(WizardReply, "interaction/replies", self.received["replies"].append, EVENTS)
        self.out = {
            name: self.peer.create_publisher(kind, f"wizard/{name}", EVENTS)
            for name, kind in (
                ("command", WizardCommand),
                ("demonstration", WizardDemonstration),
                ("handed", WizardHanded),
                ("answer", WizardAnswer),
                ("pointed", WizardPointed),
                ("revision", WizardRevision),
            )
        }
        self.tasks = self.peer.create_publisher(Task, "demonstration/task", LATCHED)
        self.targets = self.peer.create_publisher(Scene, "perception/target_scene", LATCHED)
        self.estimates = self.peer.create_publisher(MappingEstimate, "mapping/estimate", LATCHED)
        self.asked: list[str] = []
        self.task = stacking_task(N)  # that is demonstrated
        if others:
            self.peer.create_service(Observe, "perception/observe", self._observe)
            for request in ("start", "stop", "discard"):
                self.peer.create_service(Trigger, f"demonstration/{request}", self._request(request))
            self.peer.create_service(ReviseTask, "demonstration/revise", self._revise)
        self.until(lambda: all(p.get_subscription_count() for p in (*self.out.values(), self.estimates)))
        self.until(lambda: bool(self.received["state"]) and self.node.count_subscribers("interaction/replies") > 0)

    def _observe(self, request: Observe.Request, response: Observe.Response) -> Observe.Response:
        role = Role.SOURCE if request.role == Observe.Request.SOURCE else Role.TARGET
        self.asked.append(f"observe {role}")
        response.success, response.message = True, f"{N} objects"
        response.scene = scene_to_msg(row_of_objects(role, "st"[role is Role.TARGET], N))
        response.scene.header.stamp = time_to_msg(70.0)
        if role is Role.TARGET:
            self.targets.publish(response.scene)
        return response

    def _request(self, request: str) -> Callable:
        def answer(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self.asked.append(request)
            response.success, response.message = True, request
            if request == "stop":
                self._publish_task(self.task)
            return response

        return answer

    def _publish_task(self, task: DemonstratedTask) -> None:
        self.task = task
        msg = task_to_msg(task)
        msg.header.stamp = time_to_msg(50.0)
        self.tasks.publish(msg)

    def _revise(self, request: ReviseTask.Request, response: ReviseTask.Response) -> ReviseTask.Response:
        """Correct the task as the demonstration node would."""
        self.asked.append("revise")
        try:
            task = corrected(self.task, correction_from_msg(request), 51.0, None)
        except MbdError as error:
            response.message = str(error)
            return response
        response.success, response.message = True, task.problems[-1]
        self._publish_task(task)
        return response

    def until(self, done: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if done():
                return
            self.executor.spin_once(timeout_sec=0.02)
        pytest.fail(f"waited in vain; received {self.received['state'][-1:]} {self.received['replies'][-3:]}")

    def send(self, topic: str, **fields: object) -> WizardReply:
        """Send a wizard event and wait for its reply."""
        before = len(self.received["replies"])
        kinds = {
            "command": WizardCommand,
            "demonstration": WizardDemonstration,
            "handed": WizardHanded,
            "answer": WizardAnswer,
            "pointed": WizardPointed,
            "revision": WizardRevision,
        }
        self.out[topic].publish(kinds[topic](**fields))
        self.until(lambda: len(self.received["replies"]) > before)
        return self.received["replies"][-1]

    def catch_up(self) -> None:
        """Until what was received of the session is what the node holds, and no request is under way."""

        def caught_up() -> bool:
            dialogue, state = self.node._dialogue, self.received["state"][-1]
            received = (state.phase, state.step_index, len(state.assists))
            return dialogue.pending is None and received == (
                dialogue.phase,
                dialogue.state.step_index,
                len(dialogue.assists),
            )

        self.until(caught_up)

    def to_first_question(self) -> None:
        assert self.send("command", command=WizardCommand.NEXT_PHASE).accepted
        assert self.send("demonstration", command=WizardDemonstration.START).accepted
        assert self.send("demonstration", command=WizardDemonstration.STOP).accepted
        assert self.send("command", command=WizardCommand.NEXT_PHASE).accepted
        assert self.send("command", command=WizardCommand.NEXT_PHASE).accepted
        self.until(lambda: self.phase is Phase.ASSIST and bool(self.received["assists"]))
        self.infer(0.0)
        self.until(lambda: self.received["prompt"][-1].kind == Prompt.WHAT_DO_I_USE)

    def infer(self, confidence: float, **fields: object) -> None:
        """What the mapping node states of the assists last published."""
        self.until(
            lambda: stamp_from_msg(self.received["assists"][-1].header.stamp) == self.node._dialogue.assists_stamp
        )
        msg = MappingEstimate(
            confidence=confidence, threshold=0.02, confident=confidence >= 0.02, strategy="mbd", **fields
        )
        msg.mapping.pairs = [Correspondence(source_id=f"s{k}", target_id=f"t{k}") for k in range(1, N + 1)]
        msg.task_stamp, msg.scene_stamp = time_to_msg(50.0), time_to_msg(70.0)
        msg.assists_stamp = self.received["assists"][-1].header.stamp
        self.estimates.publish(msg)

    @property
    def phase(self) -> Phase:
        return Phase(self.received["state"][-1].phase)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.peer.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def make_session(ros_domain: int, tmp_path: Path) -> Iterator[Callable[..., Session]]:
    """Makes an interaction node with others around it; each one made again finds what the one before kept."""
    made: list[Session] = []

    def make(**parameters: object) -> Session:
        for earlier in made:
            earlier.close()
        made[:] = [Session(ros_domain, tmp_path, **parameters)]
        return made[0]

    yield make
    for last in made:
        last.close()


@pytest.fixture
def session(make_session: Callable[..., Session]) -> Session:
    """An interaction node with others around it that do as they are asked."""
    return make_session()


@pytest.fixture
def in_assist_phase() -> Conversation:
    """A dialogue that has asked its first question, of step 0 (pick s1)."""
    conversation = Conversation().until(Phase.ASSIST)
    conversation.infer()
    return conversation
