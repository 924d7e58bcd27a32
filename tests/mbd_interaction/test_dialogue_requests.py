"""Requests that other nodes do: the dialogue waits for them, states why they failed, and ignores late ends."""

from __future__ import annotations

from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import Call, Request
from mbd_interaction.events import Event, Signal
from mbd_interaction.transitions import transition
from mbd_model.session import Phase


def test_while_a_request_is_under_way_other_events_wait():
    first = transition(Dialogue("test"), Event(Signal.NEXT_PHASE, 1, "wizard/command"))
    assert first.effects == (Call(Request.OBSERVE_SOURCE, 1),) and first.reply is None
    second = transition(first.dialogue, Event(Signal.NEXT_PHASE, 2, "wizard/command"))
    assert second.reply and not second.reply.accepted and "still busy" in second.reply.reason
    assert second.dialogue == first.dialogue


def test_a_failed_look_stays_in_its_phase_and_answers_why():
    asked = transition(Dialogue("test"), Event(Signal.NEXT_PHASE, 1, "wizard/command")).dialogue
    failed = events.RequestDone(Signal.REQUEST_DONE, 5, token=1, success=False, message="no table in view")
    outcome = transition(asked, failed)
    assert outcome.dialogue.phase is Phase.OBSERVE_SOURCE
    assert outcome.reply and (outcome.reply.stamp, outcome.reply.accepted) == (1, False)
    assert outcome.reply.reason == "no table in view"


def test_a_result_nobody_waits_for_changes_nothing():
    dialogue = Dialogue("test")
    late = events.RequestDone(Signal.REQUEST_DONE, 5, token=0, success=True)
    assert transition(dialogue, late) == Outcome(dialogue)


def test_a_demonstration_that_shows_nothing_can_be_started_again():
    session = Conversation().until(Phase.DEMONSTRATE)
    session.do(Signal.START)
    stopping = transition(session.dialogue, Event(Signal.STOP, session.tick(), "wizard/demonstration")).dialogue
    why = "no step was demonstrated: the gripper never closed"
    session.dialogue = stopping
    session.feed(
        events.RequestDone(Signal.REQUEST_DONE, session.tick(), token=stopping.token, success=False, message=why)
    )
    assert session.dialogue.phase is Phase.DEMONSTRATE and session.reasons[-1] == why
    assert not session.dialogue.recording
    assert f"cannot use what I saw: {why}. Please start again" in session.prompts[-1].text
    assert session.do(Signal.START)
