"""The dialogue in process: its pure transitions, what they ask for done at once, everything published put on tape."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from mbd_bag.session.recorded_session import RecordedReply
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.effects import Call, Effect, PublishAssists, PublishPrompt, Request
from mbd_interaction.events import EstimateReceived, Event, RequestDone, Signal
from mbd_interaction.prompts import PHASE_TEXT
from mbd_interaction.restore import begun
from mbd_interaction.transitions import transition
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_model.estimate import EstimateInputs
from mbd_model.objects import Scene
from mbd_model.session import Phase
from mbd_model.times import to_nanoseconds

from mbd_experiments.in_process_session import Tape


@dataclass(frozen=True)
class Result:
    """What became of a request: success, a sentence, the scene it saw, and facts received besides."""

    success: bool
    message: str
    scene: Scene | None = None
    facts: tuple[Event, ...] = ()


@dataclass(frozen=True)
class MappingSettings:
    """How mappings are inferred, and below which confidence the robot asks on."""

    config: MappingConfig
    threshold: float


class DialogueLoop:
    """Feeds events to the dialogue until nothing is left to do.

    Args:
        session: its name.
        do: does a request and returns what became of it; called between events, never inside one.
        now: the time [ns].
        tape: takes states, prompts, assists, replies, estimates.
        rule: of the mapping.
        config: how the dialogue behaves.
    """

    def __init__(
        self,
        session: str,
        do: Callable[[Request], Result],
        now: Callable[[], int],
        tape: Tape,
        rule: MappingSettings,
        *,
        config: DialogueConfig | None = None,
    ) -> None:
        self._do, self._now, self._tape, self._rule = do, now, tape, rule
        self.dialogue: Dialogue = begun(session, config or DialogueConfig(), PHASE_TEXT[Phase.OBSERVE_SOURCE])
        tape.write("interaction/state", self.dialogue.state, now())

    def feed(self, event: Event) -> RecordedReply | None:
        """Take an event and everything it leads to; returns the reply to it, the last one if requests reply too."""
        events = deque([event])
        replied: RecordedReply | None = None
        while events:
            outcome = transition(self.dialogue, events.popleft())
            changed = outcome.dialogue.state != self.dialogue.state
            self.dialogue = outcome.dialogue
            if changed:
                self._tape.write("interaction/state", self.dialogue.state, self._now())
            for effect in outcome.effects:
                events.extend(self._perform(effect))
            if outcome.reply:
                replied = RecordedReply(outcome.reply.topic, outcome.reply.accepted, outcome.reply.reason)
                self._tape.write("interaction/replies", replied, outcome.reply.stamp)
        return replied

    def _perform(self, effect: Effect) -> list[Event]:
        if isinstance(effect, Call):
            result = self._do(effect.request)
            at = self._now()
            stamp = to_nanoseconds(result.scene.stamp) if result.scene else 0
            done = RequestDone(
                Signal.REQUEST_DONE, at, token=effect.token or 0, success=result.success, message=result.message,
                scene=result.scene, scene_stamp=stamp,
            )  # fmt: skip
            return [*result.facts, done]
        if isinstance(effect, PublishAssists):
            self._tape.write("interaction/assists", (effect.assists, effect.denials), effect.stamp)
            return self._estimate()
        if isinstance(effect, PublishPrompt):
            self._tape.write("interaction/prompt", effect.prompt, self._now())
        return []

    def _estimate(self) -> list[Event]:
        """What the mapping node states of the present inputs; nothing while one is missing."""
        now = self.dialogue
        if now.task is None or now.target is None:
            return []
        estimate = infer(now.task, now.target, now.assists, self._rule.config, now.denials)
        enough = estimate.confidence >= self._rule.threshold and estimate.ties <= 1
        sure = bool(estimate.mapping.pairs) and enough
        confident = sure and estimate.doubted is None
        inputs = EstimateInputs(now.task_stamp, now.target_stamp, now.assists_stamp, self._rule.threshold, confident)
        at = self._now()
        self._tape.write("mapping/estimate", (estimate, inputs), at)
        received = EstimateReceived(
            Signal.ESTIMATE, at, estimate=estimate, sure=sure, task_stamp=inputs.task_stamp,
            scene_stamp=inputs.scene_stamp, assists_stamp=inputs.assists_stamp,
        )  # fmt: skip
        return [received]
