"""Pause, abort, back and redo at any time; facts received again."""

from __future__ import annotations

import pytest
from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.effects import Call, Request
from mbd_interaction.events import Event, Signal
from mbd_model.session import Phase, PromptKind


def test_paused_it_takes_nothing_but_what_leads_on(in_assist_phase: Conversation):
    assert in_assist_phase.do(Signal.PAUSE)
    assert not in_assist_phase.answer("t1") and "paused" in in_assist_phase.reasons[-1]
    assert in_assist_phase.do(Signal.NOTE) and in_assist_phase.do(Signal.RESUME)
    assert in_assist_phase.answer("t1")


def test_an_estimate_that_came_during_a_pause_counts_on_resuming(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.do(Signal.PAUSE)
    in_assist_phase.infer(0.5)
    assert in_assist_phase.dialogue.phase is Phase.ASSIST
    in_assist_phase.do(Signal.RESUME)
    assert in_assist_phase.dialogue.phase is Phase.EXECUTE


@pytest.mark.parametrize("phase", [Phase.OBSERVE_SOURCE, Phase.DEMONSTRATE, Phase.OBSERVE_TARGET, Phase.ASSIST])
def test_aborted_it_takes_no_more(phase: Phase):
    session = Conversation().until(phase)
    assert session.do(Signal.ABORT)
    assert session.dialogue.phase is Phase.ABORTED
    assert not session.do(Signal.NEXT_PHASE)
    assert "takes resume, gripper, note" in session.reasons[-1]


@pytest.mark.parametrize("phase", [Phase.OBSERVE_SOURCE, Phase.DEMONSTRATE, Phase.OBSERVE_TARGET, Phase.ASSIST])
def test_an_abort_is_taken_back_to_the_beginning_of_its_phase_with_the_answers_there_were(phase: Phase):
    session = Conversation().until(phase)
    if phase is Phase.ASSIST:
        session.answer("t1")
    pairs, asked = session.pairs, session.prompts[-1].kind if session.prompts else PromptKind.INFORM
    assert session.do(Signal.ABORT)
    assert session.do(Signal.RESUME)
    assert session.dialogue.phase is phase
    assert (session.pairs, session.prompts[-1].kind) == (pairs, asked)
    assert not session.do(Signal.RESUME)


def test_aborting_throws_a_running_recording_away():
    session = Conversation().until(Phase.DEMONSTRATE)
    session.do(Signal.START)
    outcome = session.feed(Event(Signal.ABORT, session.tick(), "wizard/command"))
    assert Call(Request.DISCARD, None) in outcome.effects


def test_back_from_the_assists_withdraws_them(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    assert in_assist_phase.do(Signal.BACK)
    assert in_assist_phase.dialogue.phase is Phase.OBSERVE_TARGET
    assert in_assist_phase.published[-1].assists == ()


def test_back_from_executing_asks_on_however_confident(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer(0.5)
    assert in_assist_phase.do(Signal.BACK)
    assert (in_assist_phase.dialogue.phase, in_assist_phase.dialogue.step_index) == (Phase.ASSIST, 1)


def test_redoing_the_assists_asks_from_the_beginning(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert in_assist_phase.do(Signal.REDO)
    in_assist_phase.infer()
    assert in_assist_phase.dialogue.step_index == 0 and in_assist_phase.pairs == []


def test_another_target_scene_withdraws_the_assists(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    scene = in_assist_phase.dialogue.target
    in_assist_phase.feed(
        events.TargetReceived(Signal.TARGET, in_assist_phase.tick(), scene=scene, stamp=in_assist_phase.now)
    )
    assert in_assist_phase.pairs == [] and in_assist_phase.published[-1].assists == ()


def test_the_same_scene_received_again_changes_nothing(in_assist_phase: Conversation):
    before = in_assist_phase.dialogue
    in_assist_phase.feed(
        events.TargetReceived(Signal.TARGET, in_assist_phase.tick(), scene=before.target, stamp=before.target_stamp)
    )
    assert in_assist_phase.dialogue.state == before.state
