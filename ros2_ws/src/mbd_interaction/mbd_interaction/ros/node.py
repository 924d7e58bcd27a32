"""The interaction node: wizard topics and facts in, the dialogue's effects out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from mbd_model.ros.conversions import (
    assists_to_msg,
    prompt_to_msg,
    stamp_from_msg,
    stamp_to_msg,
    state_from_msg,
    state_to_msg,
)
from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.ros.run_node import run_node
from mbd_model.ros.stop_line import StopLine
from mbd_model.session import Phase
from mbd_model.session import SessionState as KeptState
from mbd_model.stop import StopLatch
from mbd_model.times import to_seconds
from mbd_msgs.msg import Assists, MappingEstimate, Progress, Prompt, Scene, SessionState, Task, WizardReply
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Header

from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue, with_assists
from mbd_interaction.effects import Call, Effect, PublishAssists, ReleaseStop, inform
from mbd_interaction.events import Event, Signal, Stopped
from mbd_interaction.parameters import INTERACTION, dialogue_config
from mbd_interaction.phases.lateness import asked_by
from mbd_interaction.prompts import PHASE_TEXT
from mbd_interaction.restore import begun, restored
from mbd_interaction.ros.conversions import (
    WIZARD_TOPICS,
    estimate_received,
    progress_received,
    target_received,
    task_received,
)
from mbd_interaction.ros.service_requests import Patience, RequestRunner
from mbd_interaction.ros.word_services import WordServices
from mbd_interaction.transitions import transition


class InteractionNode(TableNode):
    """Publishes interaction/{state, prompt, assists, replies}; calls perception/observe and demonstration/start etc."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(INTERACTION, **kwargs)
        values = self.values
        session, state_dir, config = values["session"], values["state_dir"], dialogue_config(values)
        patience = Patience(values["service_patience"], values["answer_patience"])
        self._state = LatchedPublisher(self, SessionState, "interaction/state", state_dir)
        self._assists = LatchedPublisher(self, Assists, "interaction/assists", state_dir)
        self._prompt = LatchedPublisher(self, Prompt, "interaction/prompt", state_dir)
        self._replies = self.create_publisher(WizardReply, "interaction/replies", EVENTS)
        self._requests = RequestRunner(self, patience, self._feed, self._now)
        self._kept_at = 0  # [ns] when the kept state of this session was published
        self._dialogue = self._first_dialogue(session, config)
        self._stop = StopLine(self, self._on_stop, state_dir)
        self._on_stop(self._stop.latch)  # kept over a restart
        self._heard: Counter[str] = Counter()
        self._sequence = 0
        self._words = WordServices(self, self._now)
        for topic, (msg_type, meaning) in WIZARD_TOPICS.items():
            self.create_subscription(msg_type, topic, partial(self._on_wizard, topic, meaning), EVENTS)
        for msg_type, topic, to_event in (
            (Task, "demonstration/task", task_received),
            (Scene, "perception/target_scene", target_received),
            (MappingEstimate, "mapping/estimate", estimate_received),
            (Progress, "interaction/progress", progress_received),
        ):
            self.create_subscription(msg_type, topic, partial(self._on_fact, topic, to_event), LATCHED)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(values["estimate_patience"], self._on_patience_ended, clock=steady)

    def _now(self) -> int:
        # Before the first /clock it is no earlier than when this node died: a cell that was killed, too, and comes back
        # by the time that is stated here, would begin the session's time again.
        return self.get_clock().now().nanoseconds or self._kept_at

    def _first_dialogue(self, session: str, config: DialogueConfig) -> Dialogue:
        """The kept session's dialogue when there is one of that name, else a new one; states what comes next."""
        kept = self._kept_state()
        if kept is not None and kept.session == session:
            published = self._assists.last
            stamp = stamp_from_msg(published.header.stamp) if published else 0
            dialogue = restored(kept, stamp, config)
            self._kept_at = stamp_from_msg(self._state.last.header.stamp) if self._state.last else 0
            if kept.awaiting is not dialogue.awaiting:  # a request under way, or a question, is forgotten
                self._state.publish(state_to_msg(replace(kept, awaiting=dialogue.awaiting), to_seconds(self._now())))
            held = self._state.last
            if published is None or (held is not None and _lists(published) != _lists(held)):
                dialogue = self._with_assists_republished(dialogue)
            self.get_logger().info(f"session '{session}' continues in phase {kept.phase.name}")
            return dialogue
        if kept is not None:
            self.get_logger().info(f"state_dir holds session '{kept.session}': starting '{session}' afresh")
        for latch in (self._state, self._assists, self._prompt):
            latch.forget()
        dialogue = begun(session, config, PHASE_TEXT[Phase.OBSERVE_SOURCE])
        self._state.publish(state_to_msg(dialogue.state, to_seconds(self._now())))
        self._perform(inform(dialogue.detail))
        return dialogue

    def _kept_state(self) -> KeptState | None:
        try:
            return state_from_msg(self._state.last) if self._state.last else None
        except ValueError as error:
            self.get_logger().error(f"the kept session state cannot be ({error}): starting afresh")
            return None

    def _with_assists_republished(self, dialogue: Dialogue) -> Dialogue:
        """The node died between keeping its state and publishing its assists."""
        again, effect = with_assists(dialogue, dialogue.assists, self._now())
        self._perform(effect, session=dialogue.session)
        return again

    def _on_wizard(self, topic: str, meaning: Callable[[Any, int, str], Event], msg: Any) -> None:
        self._heard[topic] += 1
        self._feed(meaning(msg, stamp_from_msg(msg.header.stamp) or self._now(), topic))

    def _on_fact(self, topic: str, to_event: Callable[[Any, int], Event], msg: Any) -> None:
        try:
            event = to_event(msg, self._now())
        except ValueError as error:  # MbdError is one
            self.get_logger().error(f"{topic} is unusable and ignored: {error}")
            return
        self._feed(event)

    def _on_stop(self, latch: StopLatch) -> None:
        # Another node's release does not resume the dialogue: that is the operator's word.
        if latch.held:
            self._feed(Stopped(Signal.STOPPED, self._now(), reason=latch.reason))

    def _on_patience_ended(self) -> None:
        if self._dialogue.phase is Phase.ASSIST and self._dialogue.belief is None:
            self._feed(Event(Signal.OVERDUE, self._now()))

    def _feed(self, event: Event) -> None:
        """Take one event: keep and publish the new state first, so that what follows can rely on it."""
        outcome = transition(asked_by(self._dialogue, self._now()), event)
        changed = outcome.dialogue.state != self._dialogue.state
        self._dialogue = outcome.dialogue
        if changed:
            self._state.publish(state_to_msg(self._dialogue.state, to_seconds(self._now())))
        for effect in outcome.effects:
            self._perform(effect)
        if outcome.reply:
            r = outcome.reply
            # rclpy ties a place in the code to one severity, so there is one place for each.
            if r.accepted:
                self.get_logger().info(f"{r.topic}: accepted: {r.reason}")
            else:
                self.get_logger().warning(f"{r.topic}: refused: {r.reason}")
            self._sequence += 1
            reply = WizardReply(
                header=Header(stamp=stamp_to_msg(r.stamp)),
                topic=r.topic,
                accepted=r.accepted,
                reason=r.reason,
                sequence=self._sequence,
                heard=self._heard[r.topic],
            )
            self._replies.publish(reply)
            self._words.replied(r.topic, r.stamp, reply)

    def _perform(self, effect: Effect, session: str = "") -> None:
        if isinstance(effect, Call):
            self._requests.run(effect)
        elif isinstance(effect, PublishAssists):
            msg = assists_to_msg(effect.assists, 0.0, session or self._dialogue.session, effect.denials)
            msg.header.stamp = stamp_to_msg(effect.stamp)
            self._assists.publish(msg)
        elif isinstance(effect, ReleaseStop):
            self._stop.release()
        else:
            self.get_logger().info(f"prompt: {effect.prompt.text}")
            self._prompt.publish(prompt_to_msg(effect.prompt, to_seconds(self._now())))


def _lists(msg: Assists | SessionState) -> tuple[list[Any], list[Any]]:
    return list(msg.assists), list(msg.denials)


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("interaction", InteractionNode)
