"""The dialogue while a robot executes the task: it waits, asks about what failed, and takes corrections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mbd_interaction import events
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import PublishPrompt
from mbd_interaction.events import Event, Signal
from mbd_interaction.synthetic import SECOND, estimate_for, random_event, results, row_of_objects, stacking_task
from mbd_interaction.transitions import TABLE, transition
from mbd_model.execution_progress import Status
from mbd_model.objects import Role
from mbd_model.session import Phase, PromptKind

CONFIG = DialogueConfig(execute=True)


def executing() -> Dialogue:
    """A session in EXECUTE after one assist, for step 1."""
    dialogue = Dialogue(
        "session",
        Phase.OBSERVE_TARGET,
        config=CONFIG,
        task=stacking_task(4),
        task_stamp=SECOND,
        target=row_of_objects(Role.TARGET, "t", 4),
        target_stamp=2 * SECOND,
    )
    asked = transition(replace(dialogue, phase=Phase.ASSIST), Event(Signal.REDO, 3 * SECOND, "wizard/command")).dialogue
    asked = transition(asked, estimate_for(asked, 4 * SECOND, 0.0)).dialogue
    assisted = transition(asked, events.Answered(Signal.HANDED, 5 * SECOND, "wizard/handed", "t1")).dialogue
    dialogue = transition(assisted, estimate_for(assisted, 6 * SECOND, 0.3)).dialogue
    assert dialogue.phase is Phase.EXECUTE
    return dialogue


def progress(dialogue: Dialogue, status: Status, step: int = -1) -> Outcome:
    received = events.ProgressReceived(
        Signal.PROGRESS, 7 * SECOND, "", step, status, "step so and so", dialogue.assists_stamp
    )  # fmt: skip
    return transition(dialogue, received)


NEXT = Event(Signal.NEXT_PHASE, 8 * SECOND, "wizard/command")


def test_the_session_is_not_done_before_the_robot_has_finished():
    dialogue = executing()
    refused = transition(dialogue, NEXT)
    assert refused.reply and not refused.reply.accepted and "has not begun" in refused.reply.reason
    under_way = progress(dialogue, Status.UNDER_WAY, 2).dialogue
    refused = transition(under_way, NEXT)
    assert refused.reply and not refused.reply.accepted and "step so and so" in refused.reply.reason
    assert transition(progress(dialogue, Status.FINISHED).dialogue, NEXT).dialogue.phase is Phase.DONE


def test_what_finished_before_the_present_assists_does_not_count():
    dialogue = executing()
    stale = events.ProgressReceived(
        Signal.PROGRESS, 7 * SECOND, "", -1, Status.FINISHED, "done", dialogue.assists_stamp - 1
    )  # fmt: skip
    assert transition(transition(dialogue, stale).dialogue, NEXT).dialogue.phase is Phase.EXECUTE


@pytest.mark.parametrize(
    ("step", "kind"),
    [(0, PromptKind.WHAT_DO_I_USE), (1, PromptKind.WHERE_DO_I_GO), (4, PromptKind.WHAT_DO_I_USE)],
)
def test_a_failed_step_is_asked_about_with_the_question_of_its_kind(step: int, kind: PromptKind):
    asked = progress(executing(), Status.FAILED, step).dialogue
    assert asked.phase is Phase.ASSIST
    outcome = transition(asked, estimate_for(asked, 9 * SECOND, 0.3))
    prompts = [e.prompt for e in outcome.effects if isinstance(e, PublishPrompt)]
    assert [(p.kind, p.step_index) for p in prompts] == [(kind, step)]


def test_the_same_object_can_be_handed_again_for_a_step_that_failed():
    asked = progress(executing(), Status.FAILED, 0).dialogue
    asked = transition(asked, estimate_for(asked, 9 * SECOND, 0.3)).dialogue
    again = transition(asked, events.Answered(Signal.HANDED, 10 * SECOND, "wizard/handed", "t1"))
    assert again.reply and again.reply.accepted
    assert transition(again.dialogue, estimate_for(again.dialogue, 11 * SECOND, 0.3)).dialogue.phase is Phase.EXECUTE


def test_a_failed_step_may_be_skipped():
    asked = progress(executing(), Status.FAILED, 0).dialogue
    asked = transition(asked, estimate_for(asked, 9 * SECOND, 0.3)).dialogue
    skipped = transition(asked, Event(Signal.SKIP, 10 * SECOND, "wizard/command"))
    assert skipped.dialogue.phase is Phase.EXECUTE
    assert skipped.dialogue.assists == ()


@pytest.mark.parametrize(
    ("signal", "at_step", "source"),
    [
        (Signal.HANDED, 2, "s3"),
        (Signal.HANDED, 3, "s3"),
        (Signal.POINTED, 3, "s1"),
        (Signal.POINTED, 2, "s1"),
    ],
)
def test_an_object_given_while_the_robot_is_at_a_step_becomes_an_assist_for_it(signal: Signal, at_step: int, source):
    under_way = progress(executing(), Status.UNDER_WAY, at_step).dialogue
    outcome = transition(under_way, events.Answered(signal, 8 * SECOND, f"wizard/{signal}", "t4"))
    assert outcome.reply and outcome.reply.accepted, outcome.reply
    assert outcome.dialogue.phase is Phase.ASSIST
    assert (source, "t4") in [(a.source_id, a.target_id) for a in outcome.dialogue.assists]


def test_an_object_given_while_nothing_is_done_is_refused_with_the_way_to_answer():
    outcome = transition(executing(), events.Answered(Signal.HANDED, 8 * SECOND, "wizard/handed", "t4"))
    assert outcome.reply and not outcome.reply.accepted and "wizard/overwrite" in outcome.reply.reason


def test_without_a_robot_execution_is_left_at_the_wizards_word():
    stated = replace(executing(), config=DialogueConfig())
    assert transition(stated, NEXT).dialogue.phase is Phase.DONE
    assert progress(stated, Status.FAILED, 0).dialogue.phase is Phase.EXECUTE


def test_random_events_with_a_robot_lead_only_where_the_table_allows():
    rng, dialogue, at = np.random.default_rng(4), executing(), 20 * SECOND
    waiting: list[Event] = []
    visited = set()
    for _ in range(6000):
        at += SECOND
        event = waiting.pop(0) if waiting and rng.random() < 0.8 else random_event(rng, dialogue, at, 4)
        if event.signal in (Signal.ABORT, Signal.BACK, Signal.REDO) and rng.random() < 0.9:
            continue
        outcome = transition(dialogue, event)
        if outcome.dialogue.phase is not dialogue.phase:
            assert outcome.dialogue.phase in TABLE[dialogue.phase, event.signal].leads_to
        waiting += results(dialogue, outcome.effects, at, 4)
        dialogue = outcome.dialogue if outcome.dialogue.phase is not Phase.ABORTED else executing()
        visited.add(dialogue.phase)
    assert {Phase.ASSIST, Phase.EXECUTE} <= visited
