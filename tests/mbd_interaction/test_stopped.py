"""A stop of the robot in the dialogue: said, latched, and ended by the operator's word alone."""

from __future__ import annotations

import pytest
from dialogue_conversation import Conversation
from mbd_interaction.effects import ReleaseStop
from mbd_interaction.events import Event, Gripped, Signal, Stopped
from mbd_interaction.transitions import transition
from mbd_model.ros.stop_line import StopLine
from mbd_model.session import Awaited, Phase
from mbd_model.stop import StopCause
from mbd_msgs.msg import SessionState, WizardCommand


@pytest.mark.parametrize("phase", [Phase.OBSERVE_SOURCE, Phase.DEMONSTRATE, Phase.OBSERVE_TARGET, Phase.ASSIST])
def test_a_stop_is_said_and_takes_nothing_but_resume_abort_and_notes_not_even_the_hand(phase: Phase):
    session = Conversation().until(phase)
    session.feed(Stopped(Signal.STOPPED, session.tick(), reason="protective stop"))
    assert session.dialogue.awaiting is Awaited.RESUME and "protective stop" in session.prompts[-1].text
    assert (
        not session.do(Signal.BACK if phase is Phase.ASSIST else Signal.REDO)
        and "protective stop" in session.reasons[-1]
    )
    assert not session.accepted(Gripped(Signal.GRIPPER, session.tick(), "wizard/gripper", close=False))
    assert "protective stop" in session.reasons[-1]
    assert session.do(Signal.NOTE)
    outcome = session.feed(Event(Signal.RESUME, session.tick(), "wizard/command"))
    assert outcome.reply is not None and outcome.reply.accepted
    assert session.accepted(Gripped(Signal.GRIPPER, session.tick(), "wizard/gripper", close=False))


@pytest.mark.parametrize("end", [Signal.ABORT, None])
def test_a_stop_after_the_session_holds_the_hand_until_resumed(end: Signal | None):
    session = Conversation()
    if end is not None:
        assert session.do(end)
    session.feed(Stopped(Signal.STOPPED, session.tick(), reason="a hand on the stop"))
    if end is None:
        assert session.do(Signal.ABORT)  # it ends the session, and releases nothing
    assert session.dialogue.phase is Phase.ABORTED and session.dialogue.standing
    assert not session.accepted(Gripped(Signal.GRIPPER, session.tick(), "wizard/gripper", close=False))
    outcome = transition(session.dialogue, Event(Signal.RESUME, session.tick(), "wizard/command"))
    assert ReleaseStop() in outcome.effects and not outcome.dialogue.standing
    # Another one takes the abort back: to let the hand go is not yet to go on.
    assert outcome.dialogue.phase is Phase.ABORTED
    taken_back = transition(outcome.dialogue, Event(Signal.RESUME, 1, "wizard/command"))
    assert taken_back.reply.accepted and taken_back.dialogue.phase is Phase.OBSERVE_SOURCE


def test_the_question_is_asked_again_when_the_robot_may_go_on(in_assist_phase: Conversation):
    question = in_assist_phase.prompts[-1]
    in_assist_phase.feed(Stopped(Signal.STOPPED, in_assist_phase.tick(), reason="so"))
    assert in_assist_phase.do(Signal.RESUME)
    assert in_assist_phase.prompts[-1] == question


def test_the_node_says_a_stop_refuses_words_and_releases_it_on_resume_alone(make_session):
    session = make_session()
    line = StopLine(session.peer)
    session.to_first_question()
    line.stop(StopCause.EMERGENCY_STOP, "the red button")
    session.until(lambda: session.received["prompt"][-1].text.startswith("I stopped: the red button"))
    session.until(lambda: session.received["state"][-1].awaiting == SessionState.AWAITING_RESUME)
    assert not session.send("handed", object_id="t1").accepted and line.latch.held
    again = make_session()  # kept over a restart of the dialogue, when nobody else is there to know
    again.until(lambda: any(p.text.startswith("I stopped: the red button") for p in again.received["prompt"]))
    assert not again.send("handed", object_id="t1").accepted
    line = StopLine(again.peer)
    again.until(lambda: line.latch.held)
    assert again.send("command", command=WizardCommand.RESUME).accepted
    again.until(lambda: not line.latch.held)
