"""A node that follows a session and reports each thing that happens in it as a line of text."""

from __future__ import annotations

import queue
from dataclasses import dataclass

from mbd_bag.session.recorded_session import RecordedReply
from mbd_model.estimate import MappingEstimate
from mbd_model.execution_progress import Progress
from mbd_model.objects import Scene
from mbd_model.ros import conversions
from mbd_model.ros.guarded_node import GuardedNode
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import Task
from mbd_msgs import msg as m
from rclpy.context import Context
from rosgraph_msgs.msg import Clock

from mbd_bringup.ros.session_end import Ending

Fact = SessionState | Prompt | RecordedReply | Progress | Scene | Task | MappingEstimate


@dataclass(frozen=True)
class SessionEvent:
    """Something that happened in the session.

    Attributes:
        speaker: who it comes from ("robot", "teacher", "wizard", "mapping", "cell").
        text: one line for people; nothing may depend on its words.
        fact: what was received; None where the line states it all.
    """

    speaker: str
    text: str
    fact: Fact | None = None

    @property
    def phase(self) -> Phase | None:
        """The phase entered, None when it is no change of phase."""
        return self.fact.phase if isinstance(self.fact, SessionState) else None


class SessionFollower(GuardedNode):
    """Subscribes to what a session publishes.

    Attributes:
        events: queue of what it received, in order.
        clock_now: the cell's time [s].
        ending: where the objects are at last.
    """

    def __init__(self, context: Context | None = None) -> None:
        super().__init__("session_follower", context=context)
        self.events: queue.SimpleQueue[SessionEvent] = queue.SimpleQueue()
        self.clock_now = 0.0
        self._phase: Phase | None = None
        self._progress: Progress | None = None
        self.ending = Ending(self)
        self.create_subscription(m.SessionState, "interaction/state", self._on_state, LATCHED)
        self.create_subscription(m.Prompt, "interaction/prompt", self._on_prompt, LATCHED)
        self.create_subscription(m.WizardReply, "interaction/replies", self._on_reply, EVENTS)
        self.create_subscription(m.WizardGripper, "wizard/gripper", self._on_gripper, EVENTS)
        self.create_subscription(m.Scene, "perception/source_scene", self._on_scene, LATCHED)
        self.create_subscription(m.Scene, "perception/target_scene", self._on_scene, LATCHED)
        self.create_subscription(m.Task, "demonstration/task", self._on_task, LATCHED)
        self.create_subscription(m.MappingEstimate, "mapping/estimate", self._on_estimate, LATCHED)
        self.create_subscription(m.Progress, "interaction/progress", self._on_progress, LATCHED)
        self.create_subscription(Clock, "/clock", self._on_clock, SENSOR)

    def _report(self, speaker: str, text: str, fact: Fact | None = None) -> None:
        self.events.put(SessionEvent(speaker, text, fact))

    def _on_clock(self, msg: Clock) -> None:
        self.clock_now = conversions.time_from_msg(msg.clock)

    def _on_state(self, msg: m.SessionState) -> None:
        state = conversions.state_from_msg(msg)
        if state.phase is not self._phase:
            self._phase = state.phase
            self._report("phase", state.phase.name.replace("_", " ").lower(), state)

    def _on_prompt(self, msg: m.Prompt) -> None:
        prompt = conversions.prompt_from_msg(msg)
        about = "" if prompt.kind is PromptKind.INFORM else f"  (step {prompt.step_index + 1}, {prompt.source_id})"
        self._report("robot", prompt.text + about, prompt)

    def _on_reply(self, msg: m.WizardReply) -> None:
        reply = RecordedReply(msg.topic, bool(msg.accepted), msg.reason)
        self._report("wizard", f"{reply.topic}: {'' if reply.accepted else 'REFUSED: '}{reply.reason}", reply)

    def _on_gripper(self, msg: m.WizardGripper) -> None:
        self._report("teacher", "close" if msg.command == m.WizardGripper.CLOSE else "open")

    def _on_progress(self, msg: m.Progress) -> None:
        progress = conversions.progress_from_msg(msg)
        if self._progress is None or progress.doing != self._progress.doing:
            self._report("arm", progress.text, progress)
        self._progress = progress

    def _on_scene(self, msg: m.Scene) -> None:
        scene = conversions.scene_from_msg(msg)
        names = ", ".join(f"{o.object_id} {o.color_name} {o.object_class}".strip() for o in scene.objects)
        self._report("perception", f"{len(scene.objects)} {scene.role} objects: {names}", scene)

    def _on_task(self, msg: m.Task) -> None:
        task = conversions.task_from_msg(msg)
        steps = ", ".join(f"{s.index + 1} {s.kind.name.lower()} {s.primary_object}" for s in task.steps)
        self._report("demonstration", f"{len(task.steps)} steps: {steps}", task)
        for problem in task.problems:
            self._report("demonstration", problem)

    def _on_estimate(self, msg: m.MappingEstimate) -> None:
        estimate = conversions.estimate_from_msg(msg)
        pairs = " ".join(f"{source}>{target}" for source, target in estimate.mapping.pairs)
        sure = "confident" if msg.confident else "not sure yet"
        doubted = estimate.doubted
        if doubted is not None:
            sure += f", doubts {doubted.source_id}>{doubted.target_id} ({estimate.doubt:.2f})"
        self._report(
            "mapping",
            f"{msg.num_assists} assists: {pairs}  confidence {msg.confidence:.3f} ({sure}, {'+'.join(msg.winning)})",
            estimate,
        )
