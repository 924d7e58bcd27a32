"""What the console shows follows from what it receives."""

from __future__ import annotations

import dataclasses

import pytest
from mbd_console import state as console_state
from mbd_console.actions import ACTIONS, KEYS, OBJECT_KEYS, Action, offered
from mbd_console.requests import next_meant_step
from mbd_console.state import ConsoleState
from mbd_console.status.event_log import Tone
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import WIZARD, Event, Signal
from mbd_interaction.synthetic import SECOND, results, row_of_objects, stacking_task
from mbd_interaction.transitions import TABLE, transition
from mbd_model.assists import Assist
from mbd_model.estimate import Mapping, MappingEstimate
from mbd_model.execution_progress import Progress, Status
from mbd_model.objects import Role
from mbd_model.session import Phase, Prompt, PromptKind, SessionState


def in_phase(phase: Phase, **also: object) -> ConsoleState:
    task = stacking_task(4)
    session = SessionState("s", phase, **also)
    return ConsoleState(
        session=session, task=task, source=task.source, target=row_of_objects(Role.TARGET, "t", 4), question=7
    )


def test_every_action_has_a_key_of_its_own_and_none_is_a_number():
    assert len(KEYS) == len(ACTIONS) == len(Action)
    assert not set(KEYS) & set(OBJECT_KEYS)
    assert all(spec.key_label and spec.label() and spec.hint() for spec in ACTIONS.values())


def test_every_event_a_wizard_can_send_is_on_the_console():
    on_console = {signal for spec in ACTIONS.values() for signal in spec.signals}
    by_object = {Signal.HANDED, Signal.POINTED}
    assert on_console | by_object == set(WIZARD) - {Signal.UNREADABLE}


@pytest.mark.parametrize("phase", Phase)
def test_no_button_offers_what_the_phase_never_takes(phase: Phase):
    state = in_phase(phase, step_index=0, assists=(Assist("s1", "t1"),))
    for action, spec in ACTIONS.items():
        if spec.signals and offered(state, action):
            assert any((phase, signal) in TABLE for signal in spec.signals), action


def test_a_paused_session_offers_only_what_a_paused_dialogue_takes():
    state = in_phase(Phase.ASSIST, paused=True, step_index=0, assists=(Assist("s1", "t1"),))
    dialogue_offers = {a for a in Action if ACTIONS[a].signals and offered(state, a)}
    assert dialogue_offers == {Action.PAUSE, Action.ABORT, Action.OPEN, Action.CLOSE, Action.NOTE}


def test_it_shows_a_recording_exactly_while_the_dialogue_has_one_made():
    dialogue, at = Dialogue("s"), SECOND
    shown = []
    for signal in (Signal.NEXT_PHASE, Signal.START, Signal.REDO, Signal.START, Signal.STOP):
        events = [Event(signal, at, "wizard/x")]
        while events:
            at += SECOND
            before, outcome = dialogue, transition(dialogue, events.pop(0))
            dialogue = outcome.dialogue
            events += results(before, outcome.effects, at, 4)
        state = console_state.on_session(ConsoleState(), dialogue.state, 0.0)
        shown.append(state.recording)
        assert state.recording == dialogue.recording
    assert shown == [False, True, False, True, False]


def test_another_session_is_shown_from_scratch():
    old = dataclasses.replace(in_phase(Phase.ASSIST), closed=True)
    new = console_state.on_session(old, SessionState("other", Phase.OBSERVE_SOURCE), 50.0)
    assert (new.task, new.source, new.target, new.estimate, new.confidences) == (None, None, None, None, ())
    assert new.began == 50.0


def test_the_phase_clock_starts_with_the_phase_and_the_session_clock_does_not():
    state = console_state.on_session(ConsoleState(), SessionState("s", Phase.OBSERVE_SOURCE), 10.0)
    state = console_state.on_session(state, SessionState("s", Phase.OBSERVE_SOURCE, detail="x"), 12.0)
    assert (state.began, state.phase_began) == (10.0, 10.0)
    state = console_state.on_session(state, SessionState("s", Phase.DEMONSTRATE), 20.0)
    assert (state.began, state.phase_began) == (10.0, 20.0)
    assert [line.text for line in state.log] == ["Demonstrate", "Observe source"]


def test_facts_latched_before_the_session_was_received_are_kept():
    early = console_state.on_task(ConsoleState(), stacking_task(4))
    state = console_state.on_session(early, SessionState("s", Phase.ASSIST), 1.0)
    assert state.task is not None


def test_each_prompt_is_another_question():
    prompt = Prompt(PromptKind.WHAT_DO_I_USE, "What do I use now?", 0, "s1")
    once = console_state.on_prompt(ConsoleState(), prompt, 1.0)
    assert console_state.on_prompt(once, prompt, 2.0).question == once.question + 1


def test_an_estimate_published_again_is_no_new_point_of_the_confidence():
    estimate = MappingEstimate("mbd", Mapping((("s1", "t1"),)), 0.1)
    state = console_state.on_estimate(ConsoleState(), estimate, 0.02, True, 1.0)
    state = console_state.on_estimate(state, estimate, 0.02, True, 2.0)
    assert len(state.confidences) == 1
    state = console_state.on_estimate(
        state, dataclasses.replace(estimate, confidence=0.2, num_assists=1), 0.02, True, 3.0
    )
    assert [(p.at, p.value, p.num_assists) for p in state.confidences] == [(1.0, 0.1, 0), (3.0, 0.2, 1)]


def test_the_log_is_newest_first_and_bounded():
    state = ConsoleState()
    for k in range(console_state.LOG_LENGTH + 5):
        state = console_state.logged(state, float(k), Tone.NOTE, "note", str(k))
    assert len(state.log) == console_state.LOG_LENGTH
    assert state.log[0].text == str(console_state.LOG_LENGTH + 4)


def test_what_the_teacher_picked_up_is_no_longer_outlined_where_it_stood():
    state = in_phase(Phase.DEMONSTRATE)
    standing = {o.object_id for o in state.on_table}
    assert standing == {"s2"}


def executing(statuses: tuple[Status, ...], text: str = "step 2 under way") -> ConsoleState:
    pairs = (("s1", "t3"), ("s2", "t1"), ("s3", "t2"), ("s4", "t4"))
    state = dataclasses.replace(in_phase(Phase.EXECUTE), estimate=MappingEstimate("mbd", Mapping(pairs), 0.1))
    return console_state.on_progress(state, Progress(1, Status.UNDER_WAY, text, statuses), "s", 1.0)


def test_what_the_robot_took_away_alone_is_no_longer_outlined_where_it_stood():
    # The steps: pick s1, place onto s2, pick s3 ...: s1 is t3.
    state = executing((Status.DONE, Status.UNDER_WAY, *[Status.PLANNED] * 4))
    assert {o.object_id for o in state.on_table} == {"t1", "t2", "t4"}


def test_progress_of_another_task_marks_no_step():
    assert executing((Status.DONE,)).step_statuses == ()


def test_progress_of_another_session_is_not_shown():
    state = in_phase(Phase.EXECUTE)
    assert console_state.on_progress(state, Progress(0, Status.DONE, "x", ()), "other", 1.0) is state


def test_a_correction_begins_with_the_step_the_robot_is_at():
    state = executing((Status.DONE, Status.UNDER_WAY, *[Status.PLANNED] * 4))
    assert next_meant_step({}, state, -1) == 1


def test_a_teacher_who_repeats_himself_fills_no_log():
    state = console_state.on_speech(ConsoleState(), 2, "close", 1.0)
    assert console_state.on_speech(state, 2, "close", 2.0) is state
    state = console_state.on_gripper(state, close=True)
    assert len(console_state.on_speech(state, 2, "close", 3.0).log) == 2
