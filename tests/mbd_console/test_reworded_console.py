"""The console offers and does the same whatever sentences reach it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import mbd_msgs.action
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_console import state as console_state
from mbd_console.actions import Action, offered
from mbd_console.requests import ConsoleRequest, RequestRefusedError, next_meant_step, read_request
from mbd_console.state import ConsoleState
from mbd_interaction import events
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import PublishPrompt
from mbd_interaction.events import Event
from mbd_interaction.synthetic import SECOND, random_walk, row_of_objects
from mbd_model.execution_progress import Progress, Purpose, Status
from mbd_model.objects import Role
from mbd_model.session import SessionState
from mbd_msgs import msg as m
from mbd_msgs import srv
from rewording import REWORDINGS, TEXTS, Rewording, reworded

ALWAYS = {Action.OPEN, Action.CLOSE, Action.NOTE}
RAW = [*({"action": a} for a in Action if a is not Action.NOTE), {"action": "object", "object_id": "t1"}]
Change = Callable[[ConsoleState], ConsoleState]
# Texts by which machines know things.
NAMES = frozenset(
    [
        "session",
        "task",
        "strategy",
        "topic",
        "name",
        "id",
        "object",
        "object_id",
        "receiver_id",
        "source_id",
        "target_id",
        "other_id",
        "source_name",
        "target_names",
        "primary_object",
        "runner_up",
        "next_question",
        "question_targets",
        "target_ids",
        "source_ids",
        "winning",
        "color_name",
        "object_class",
        "affordances",
        "properties",
        # Of forms: what was asked and answered, as it was shown, decides nothing.
        "form",
        "item",
        "version",
        "language",
        "value",
        "shown",
        "marker",
        # Of the session that is next.
        "participant",
        "condition",
        "problem",
    ]
)
PLANE = (0.0, 0.0, 1.0, 0.0)


def shown(event: Event, outcome: Outcome, words: Rewording) -> Iterator[Change]:
    """What the console receives when that happens, in other words."""

    def reword(value: object) -> object:
        return reworded(value, words)

    at = event.at / SECOND
    if isinstance(event, events.TaskReceived) and event.task is not None:
        yield lambda state: console_state.on_recorded(
            console_state.on_task(state, reword(event.task)), reword(event.task)
        )
    if isinstance(event, events.TargetReceived) and event.scene is not None:
        yield lambda state: console_state.on_scene(state, reword(event.scene), PLANE)
    if isinstance(event, events.EstimateReceived) and event.estimate is not None:
        yield lambda state: console_state.on_estimate(state, reword(event.estimate), 0.02, event.sure, at)
    if isinstance(event, events.ProgressReceived):
        purpose = Purpose.PICK if event.status is Status.UNDER_WAY else Purpose.NONE
        statuses = (event.status,) * 8
        progress = Progress(event.step_index, event.status, event.text, statuses, purpose, f"t{event.step_index}")
        yield lambda state: console_state.on_progress(state, reword(progress), outcome.dialogue.session, at)
    if isinstance(event, events.Gripped):
        yield lambda state: console_state.on_gripper(state, event.close)
    yield lambda state: console_state.on_session(state, reword(outcome.dialogue.state), at)
    for effect in outcome.effects:
        if isinstance(effect, PublishPrompt):
            yield lambda state, prompt=effect.prompt: console_state.on_prompt(state, reword(prompt), at)
    if outcome.reply:
        reply = reword(outcome.reply)
        yield lambda state: console_state.on_reply(state, reply.topic, reply.accepted, reply.reason, at)


def decided(state: ConsoleState) -> object:
    """Everything the console decides: what it offers, makes of requests, and marks on its page."""
    marks = (state.recording, state.asked, state.step_statuses, console_state.asks(state.prompt), state.closed)
    places = [o.object_id for o in state.on_table]
    log = [(line.at, line.tone, line.speaker) for line in state.log]
    requests = [answer({**raw, "question": state.question}, state) for raw in RAW]
    return actions(state), requests, meant(state), marks, places, log


def actions(state: ConsoleState) -> frozenset[Action]:
    return frozenset(a for a in Action if offered(state, a))


def answer(raw: dict[str, object], state: ConsoleState) -> ConsoleRequest | None:
    try:
        return read_request(raw, state)
    except RequestRefusedError:
        return None


def meant(state: ConsoleState) -> int | None:
    try:
        return next_meant_step({}, state, -1)
    except RequestRefusedError:
        return None


def beginning(dialogue: Dialogue) -> ConsoleState:
    state = console_state.on_session(ConsoleState(), dialogue.state, 0.0)
    return console_state.on_scene(state, row_of_objects(Role.SOURCE, "s", 5), PLANE)


def compared(seed: int, n_events: int, words: Rewording) -> tuple[set[frozenset[Action]], set[bool]]:
    """Show a random session in its own and in other words; what was offered, and whether it recorded, at some time."""
    start = Dialogue("random", config=DialogueConfig(execute=bool(seed % 2)))
    plain = other = beginning(start)
    offers, recordings = set(), set()
    for _, event, outcome in random_walk(np.random.default_rng(seed), n_events, start, led=0.3):
        for change, reworded_change in zip(
            shown(event, outcome, lambda text: text), shown(event, outcome, words), strict=True
        ):
            plain, other = change(plain), reworded_change(other)
        assert decided(other) == decided(plain), (event, outcome.dialogue.state)
        offers.add(actions(plain))
        recordings.add(plain.recording)
    return offers, recordings


@given(seed=st.integers(0, 2**32), words=st.sampled_from(list(REWORDINGS.values())))
def test_reworded_a_session_is_led_by_the_same_console(seed: int, words: Rewording):
    compared(seed, 60, words)


@pytest.mark.parametrize("words", REWORDINGS.values(), ids=REWORDINGS)
def test_reworded_a_long_session_offers_every_action_when_its_own_words_would(words: Rewording):
    offers, recordings = compared(3, 1000, words)
    assert recordings == {True, False}
    for action in set(Action) - ALWAYS:
        assert {action in now for now in offers} == {True, False}, f"{action} is always or never offered"


@pytest.mark.parametrize("words", REWORDINGS.values(), ids=REWORDINGS)
def test_a_robot_that_does_another_thing_is_logged_once_whatever_it_states_of_it(words: Rewording):
    session = SessionState("s", Dialogue("s").phase)
    state = console_state.on_session(ConsoleState(), session, 0.0)
    lines = len(state.log)
    doing = (Purpose.PICK, Purpose.PICK, Purpose.RETURN, Purpose.RETURN, Purpose.PICK)
    for second, purpose in enumerate(doing):
        progress = Progress(0, Status.UNDER_WAY, f"{purpose.words} t1", (), purpose, "t1")
        state = console_state.on_progress(state, reworded(progress, words), "s", float(second))
    assert len(state.log) - lines == 3


def test_every_text_of_a_message_is_a_sentence_that_is_reworded_or_a_name():
    """A sentence added to a message under another name would escape these tests."""
    kinds = [k for module in (m, srv, mbd_msgs.action) for k in vars(module).values() if isinstance(k, type)]
    parts = [getattr(k, part) for k in kinds for part in ("Request", "Response", "Goal", "Result") if hasattr(k, part)]
    messages = [k for k in (*kinds, *parts) if hasattr(k, "get_fields_and_field_types")]
    fields = [pair for k in messages for pair in k.get_fields_and_field_types().items()]
    found = {name for name, of in fields if of.endswith(("string", "string>"))}
    assert {"SessionState", "Progress", "Prompt", "WizardReply", "Task"} <= {k.__name__ for k in messages}
    assert found <= TEXTS | NAMES, found - TEXTS - NAMES
