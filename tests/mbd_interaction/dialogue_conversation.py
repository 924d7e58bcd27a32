"""A dialogue to talk with: events in, what it states and publishes kept."""

from __future__ import annotations

from mbd_interaction import events
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import PublishAssists, PublishPrompt
from mbd_interaction.events import Event, Signal
from mbd_interaction.synthetic import SECOND, estimate_for, results
from mbd_interaction.transitions import transition
from mbd_model.session import Phase, Prompt, PromptKind

N = 4


class Conversation:
    """A dialogue whose other nodes do well; time goes on a second with each event."""

    def __init__(self, *, confidence: float = 0.0, config: DialogueConfig | None = None) -> None:
        self.dialogue = Dialogue("test", config=config or DialogueConfig())
        self.confidence = confidence
        self.now = SECOND
        self.prompts: list[Prompt] = []
        self.published: list[PublishAssists] = []
        self.reasons: list[str] = []

    def feed(self, event: Event) -> Outcome:
        before = self.dialogue
        outcome = transition(self.dialogue, event)
        self.dialogue = outcome.dialogue
        self.prompts += [e.prompt for e in outcome.effects if isinstance(e, PublishPrompt)]
        self.published += [e for e in outcome.effects if isinstance(e, PublishAssists)]
        self.reasons += [outcome.reply.reason] if outcome.reply else []
        for answer in results(before, outcome.effects, self.tick(), N):
            later = self.feed(answer)
            outcome = later if later.reply else outcome
        return outcome

    def tick(self) -> int:
        self.now += SECOND
        return self.now

    def do(self, signal: Signal) -> bool:
        return self.accepted(Event(signal, self.tick(), "wizard/command"))

    def answer(self, object_id: str, signal: Signal | None = None) -> bool:
        kind = self.prompts[-1].kind
        signal = signal or (Signal.HANDED if kind is PromptKind.WHAT_DO_I_USE else Signal.POINTED)
        return self.accepted(events.Answered(signal, self.tick(), f"wizard/{signal}", object_id))

    def point(self, *place: float) -> bool:
        x, y, z = place
        return self.accepted(events.Answered(Signal.POINTED, self.tick(), "wizard/pointed", "", (x, y, z)))

    def mean(self, step_index: int, object_id: str) -> bool:
        event = events.Overwritten(Signal.OVERWRITE, self.tick(), "wizard/overwrite", step_index, object_id)
        return self.accepted(event)

    def accepted(self, event: Event) -> bool:
        outcome = self.feed(event)
        assert outcome.reply is not None and outcome.reply.reason
        return outcome.reply.accepted

    def infer(self, confidence: float | None = None) -> None:
        self.feed(estimate_for(self.dialogue, self.tick(), self.confidence if confidence is None else confidence))

    def until(self, phase: Phase) -> Conversation:
        order = [Signal.NEXT_PHASE, Signal.START, Signal.STOP, Signal.NEXT_PHASE, Signal.NEXT_PHASE]
        for signal in order:
            if self.dialogue.phase is phase and signal is not Signal.STOP:
                break
            assert self.do(signal), self.reasons[-1]
        assert self.dialogue.phase is phase
        return self

    @property
    def pairs(self) -> list[tuple[str, str]]:
        return [(a.source_id, a.target_id) for a in self.dialogue.assists]
