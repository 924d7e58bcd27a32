"""Pause, abort, back and redo at any time; facts heard anew."""

from __future__ import annotations

import pytest
from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.dialogue import Call, Deed
from mbd_interaction.events import Event, Signal
from mbd_model.session import Phase


def test_paused_it_takes_nothing_but_what_leads_on(asking: Conversation):
    assert asking.do(Signal.PAUSE)
    assert not asking.answer("t1") and "paused" in asking.reasons[-1]
    assert asking.do(Signal.NOTE) and asking.do(Signal.RESUME)
    assert asking.answer("t1")


def test_an_estimate_that_came_during_a_pause_counts_on_resuming(asking: Conversation):
    asking.answer("t1")
    asking.do(Signal.PAUSE)
    asking.infer(0.5)
    assert asking.dialogue.phase is Phase.ASSIST
    asking.do(Signal.RESUME)
    assert asking.dialogue.phase is Phase.CARRY_ON


@pytest.mark.parametrize("phase", [Phase.OBSERVE_SOURCE, Phase.DEMONSTRATE, Phase.OBSERVE_TARGET, Phase.ASSIST])
def test_aborted_it_takes_no_more(phase: Phase):
    session = Conversation().until(phase)
    assert session.do(Signal.ABORT)
    assert session.dialogue.phase is Phase.ABORTED
    assert not session.do(Signal.NEXT_PHASE)
    assert "takes gripper, note" in session.reasons[-1]


def test_aborting_throws_a_running_recording_away():
    session = Conversation().until(Phase.DEMONSTRATE)
    session.do(Signal.START)
    outcome = session.feed(Event(Signal.ABORT, session.tick(), "wizard/command"))
    assert Call(Deed.DISCARD, None) in outcome.effects


def test_back_from_the_assists_withdraws_them(asking: Conversation):
    asking.answer("t1")
    assert asking.do(Signal.BACK)
    assert asking.dialogue.phase is Phase.OBSERVE_TARGET
    assert asking.published[-1].assists == ()


def test_back_from_carrying_on_asks_on_however_confident(asking: Conversation):
    asking.answer("t1")
    asking.infer(0.5)
    assert asking.do(Signal.BACK)
    assert (asking.dialogue.phase, asking.dialogue.step_index) == (Phase.ASSIST, 1)


def test_redoing_the_assists_asks_from_the_beginning(asking: Conversation):
    asking.answer("t1")
    asking.infer()
    assert asking.do(Signal.REDO)
    asking.infer()
    assert asking.dialogue.step_index == 0 and asking.pairs == []


def test_another_target_scene_withdraws_the_assists(asking: Conversation):
    asking.answer("t1")
    scene = asking.dialogue.target
    asking.feed(events.TargetHeard(Signal.TARGET, asking.tick(), scene=scene, stamp=asking.now))
    assert asking.pairs == [] and asking.published[-1].assists == ()


def test_the_same_scene_heard_again_changes_nothing(asking: Conversation):
    before = asking.dialogue
    asking.feed(events.TargetHeard(Signal.TARGET, asking.tick(), scene=before.target, stamp=before.target_stamp))
    assert asking.dialogue.state == before.state
