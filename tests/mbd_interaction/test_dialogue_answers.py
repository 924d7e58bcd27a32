"""Answers and corrections: handed, pointed, wrong, repeated, undone, meant otherwise, skipped."""

from __future__ import annotations

from dataclasses import replace

import pytest
from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.events import Signal
from mbd_interaction.phases.lateness import asked_by
from mbd_interaction.synthetic import SECOND
from mbd_interaction.transitions import transition
from mbd_model.session import Phase


def test_a_pointed_place_is_the_nearest_object_by_its_surface(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert in_assist_phase.point(0.45, 0.47, 0.02)
    assert in_assist_phase.pairs[-1] == ("s2", "t2")


def test_a_place_far_from_every_object_is_refused(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert not in_assist_phase.point(-1.0, 0.0, 0.0)
    assert "no target object is within" in in_assist_phase.reasons[-1]


def test_an_object_in_the_hand_is_not_where_a_place_is_pointed_at(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert not in_assist_phase.point(0.5, 0.2, 0.05)
    assert in_assist_phase.point(0.5, 0.27, 0.05)
    assert in_assist_phase.pairs[-1] == ("s2", "t2")


def test_an_unknown_object_is_refused_with_the_known_ones(in_assist_phase: Conversation):
    assert not in_assist_phase.answer("t99")
    assert "['t1', 't2', 't3', 't4']" in in_assist_phase.reasons[-1]


def test_the_wrong_kind_of_answer_is_refused(in_assist_phase: Conversation):
    assert not in_assist_phase.answer("t1", Signal.POINTED)
    assert "answer it on wizard/handed" in in_assist_phase.reasons[-1]


def test_an_answer_to_an_earlier_question_is_late(in_assist_phase: Conversation):
    late = events.Answered(Signal.HANDED, in_assist_phase.dialogue.asked_at - SECOND, "wizard/handed", "t1")
    assert not in_assist_phase.accepted(late)
    assert "late" in in_assist_phase.reasons[-1]


def test_a_question_of_a_clock_that_was_ahead_is_answered_once_it_is_right_again(in_assist_phase: Conversation):
    now = in_assist_phase.dialogue.asked_at
    ahead = replace(in_assist_phase.dialogue, asked_at=now + 3600 * SECOND)
    answer = events.Answered(Signal.HANDED, now, "wizard/handed", "t1")
    refused, taken = transition(ahead, answer).reply, transition(asked_by(ahead, now), answer).reply
    assert not refused.accepted and "late" in refused.reason
    assert taken.accepted
    assert asked_by(in_assist_phase.dialogue, now + SECOND) == in_assist_phase.dialogue


def test_the_same_assist_twice_counts_once(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    assert not in_assist_phase.answer("t1", Signal.HANDED)
    in_assist_phase.infer()
    assert not in_assist_phase.answer("t1", Signal.POINTED)
    assert "repeated" in in_assist_phase.reasons[-1]
    assert in_assist_phase.pairs == [("s1", "t1")]


def test_undo_withdraws_the_last_assist_and_asks_again_however_confident(in_assist_phase: Conversation):
    in_assist_phase.answer("t2")
    in_assist_phase.infer(0.5)
    assert in_assist_phase.dialogue.phase is Phase.EXECUTE
    assert in_assist_phase.do(Signal.UNDO)
    assert in_assist_phase.published[-1].assists == ()
    in_assist_phase.infer(0.5)
    assert (in_assist_phase.dialogue.phase, in_assist_phase.dialogue.step_index) == (Phase.ASSIST, 0)


def test_undo_without_assists_is_refused(in_assist_phase: Conversation):
    assert not in_assist_phase.do(Signal.UNDO)


def test_overwriting_replaces_the_assist_in_its_place(in_assist_phase: Conversation):
    for target in ("t2", "t3"):
        in_assist_phase.answer(target)
        in_assist_phase.infer()
    assert in_assist_phase.mean(0, "t1")
    assert in_assist_phase.pairs == [("s1", "t1"), ("s2", "t3")]
    in_assist_phase.infer()
    assert in_assist_phase.dialogue.step_index == 2


@pytest.mark.parametrize(
    ("step", "target", "why"), [(0, "t9", "unknown"), (9, "t1", "no step"), (4, "t4", "no assist")]
)
def test_an_overwrite_that_fits_nothing_is_refused(in_assist_phase: Conversation, step: int, target: str, why: str):
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert not in_assist_phase.mean(step, target)
    assert why in in_assist_phase.reasons[-1]


def test_a_correction_while_executing_becomes_an_assist_and_is_mapped_again(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer(0.5)
    assert in_assist_phase.mean(2, "t4")
    assert in_assist_phase.pairs == [("s1", "t1"), ("s3", "t4")]
    assert in_assist_phase.dialogue.phase is Phase.ASSIST
    in_assist_phase.infer(0.5)
    assert in_assist_phase.dialogue.phase is Phase.EXECUTE


def test_a_skipped_step_is_left_without_an_assist(in_assist_phase: Conversation):
    assert in_assist_phase.do(Signal.SKIP)
    assert in_assist_phase.dialogue.step_index == 1
    assert in_assist_phase.pairs == []


def test_when_everything_is_skipped_it_goes_on_alone(in_assist_phase: Conversation):
    while in_assist_phase.dialogue.phase is Phase.ASSIST:
        assert in_assist_phase.do(Signal.SKIP)
    assert in_assist_phase.dialogue.phase is Phase.EXECUTE
