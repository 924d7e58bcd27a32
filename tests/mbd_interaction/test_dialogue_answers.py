"""Answers and corrections: handed, pointed, wrong, repeated, undone, meant otherwise, skipped."""

from __future__ import annotations

import pytest
from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.events import Signal
from mbd_interaction.synthetic import SECOND
from mbd_model.session import Phase


def test_a_pointed_place_is_the_nearest_object_by_its_surface(asking: Conversation):
    asking.answer("t1")
    asking.infer()
    assert asking.point(0.45, 0.47, 0.02)
    assert asking.pairs[-1] == ("s2", "t2")


def test_a_place_far_from_every_object_is_refused(asking: Conversation):
    asking.answer("t1")
    asking.infer()
    assert not asking.point(-1.0, 0.0, 0.0)
    assert "no target object is within" in asking.reasons[-1]


def test_an_object_in_the_hand_is_not_where_a_place_is_pointed_at(asking: Conversation):
    asking.answer("t1")
    asking.infer()
    assert not asking.point(0.5, 0.2, 0.05)
    assert asking.point(0.5, 0.27, 0.05)
    assert asking.pairs[-1] == ("s2", "t2")


def test_an_unknown_object_is_refused_with_the_known_ones(asking: Conversation):
    assert not asking.answer("t99")
    assert "['t1', 't2', 't3', 't4']" in asking.reasons[-1]


def test_the_wrong_kind_of_answer_is_refused(asking: Conversation):
    assert not asking.answer("t1", Signal.POINTED)
    assert "answer it on wizard/handed" in asking.reasons[-1]


def test_an_answer_to_an_earlier_question_is_late(asking: Conversation):
    late = events.Answered(Signal.HANDED, asking.dialogue.asked_at - SECOND, "wizard/handed", "t1")
    assert not asking.accepted(late)
    assert "late" in asking.reasons[-1]


def test_the_same_assist_twice_counts_once(asking: Conversation):
    asking.answer("t1")
    assert not asking.answer("t1", Signal.HANDED)
    asking.infer()
    assert not asking.answer("t1", Signal.POINTED)
    assert "repeated" in asking.reasons[-1]
    assert asking.pairs == [("s1", "t1")]


def test_undo_withdraws_the_last_assist_and_asks_again_however_confident(asking: Conversation):
    asking.answer("t2")
    asking.infer(0.5)
    assert asking.dialogue.phase is Phase.CARRY_ON
    assert asking.do(Signal.UNDO)
    assert asking.published[-1].assists == ()
    asking.infer(0.5)
    assert (asking.dialogue.phase, asking.dialogue.step_index) == (Phase.ASSIST, 0)


def test_undo_without_assists_is_refused(asking: Conversation):
    assert not asking.do(Signal.UNDO)


def test_overwriting_replaces_the_assist_in_its_place(asking: Conversation):
    for target in ("t2", "t3"):
        asking.answer(target)
        asking.infer()
    assert asking.mean(0, "t1")
    assert asking.pairs == [("s1", "t1"), ("s2", "t3")]
    asking.infer()
    assert asking.dialogue.step_index == 2


@pytest.mark.parametrize(
    ("step", "target", "why"), [(0, "t9", "unknown"), (9, "t1", "no step"), (4, "t4", "no assist")]
)
def test_an_overwrite_that_fits_nothing_is_refused(asking: Conversation, step: int, target: str, why: str):
    asking.answer("t1")
    asking.infer()
    assert not asking.mean(step, target)
    assert why in asking.reasons[-1]


def test_a_correction_while_carrying_on_becomes_an_assist_and_is_mapped_again(asking: Conversation):
    asking.answer("t1")
    asking.infer(0.5)
    assert asking.mean(2, "t4")
    assert asking.pairs == [("s1", "t1"), ("s3", "t4")]
    assert asking.dialogue.phase is Phase.ASSIST
    asking.infer(0.5)
    assert asking.dialogue.phase is Phase.CARRY_ON


def test_a_skipped_step_is_left_without_an_assist(asking: Conversation):
    assert asking.do(Signal.SKIP)
    assert asking.dialogue.step_index == 1
    assert asking.pairs == []


def test_when_everything_is_skipped_it_goes_on_alone(asking: Conversation):
    while asking.dialogue.phase is Phase.ASSIST:
        assert asking.do(Signal.SKIP)
    assert asking.dialogue.phase is Phase.CARRY_ON
