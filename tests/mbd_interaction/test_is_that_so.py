"""The robot never goes on alone against what it was told without having asked about it; yes, no and undo mean that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from dialogue_conversation import Conversation
from hypothesis import given
from hypothesis import strategies as st
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import Event, Signal, TargetReceived, TaskReceived
from mbd_interaction.restore import restored
from mbd_interaction.synthetic import SECOND, estimate_for, random_walk
from mbd_interaction.transitions import transition
from mbd_model.assists import Denial
from mbd_model.estimate import Mapping, QuestionKind
from mbd_model.session import Awaited, Phase, PromptKind

NAMING = DialogueConfig(question_kinds=(QuestionKind.WHAT_NEXT, QuestionKind.IS_THIS_IT, QuestionKind.WHICH_OF_TWO))
STARTS = [Dialogue("r"), Dialogue("r", config=replace(NAMING, execute=True))]


def infer(conversation: Conversation, confidence: float = 0.5, **fields: object) -> None:
    conversation.feed(estimate_for(conversation.dialogue, conversation.tick(), confidence, **fields))


def doubting(config: DialogueConfig | None = None) -> Conversation:
    """A dialogue told t3 for s1 and t2 for s2, that is sure of the rest but doubts the first."""
    conversation = Conversation(config=config).until(Phase.ASSIST)
    infer(conversation, 0.0)
    conversation.answer("t3")
    infer(conversation, 0.0)
    conversation.answer("t2")
    infer(conversation, 0.5, doubted=conversation.dialogue.assists[0], doubt=0.7)
    return conversation


def naming(kind: QuestionKind, *targets: str) -> Conversation:
    """A dialogue that would learn most about s1 (picked in step 1) by a question that names these objects."""
    conversation = Conversation(config=NAMING).until(Phase.ASSIST)
    infer(conversation, 0.0, next_question="s1", question_kind=kind, question_targets=targets)
    return conversation


@given(seed=st.integers(0, 2**32), start=st.sampled_from(STARTS))
def test_it_never_executes_against_an_assist_that_it_did_not_ask_about(seed: int, start: Dialogue):
    asked: set[tuple[str, str]] = set()
    asked_about: set[str] = set()  # what was given for these after all was thought over
    for before, _, outcome in random_walk(np.random.default_rng(seed), 250, start, n=4, led=0.5):
        after = outcome.dialogue
        asked = {pair for pair in asked if pair in {(a.source_id, a.target_id) for a in before.assists}}
        if after.question and after.question.kind is PromptKind.CONFIRM_ASSIST:
            asked.add((after.steps[after.step_index].primary_object, after.question.target_ids[0]))
            asked_about.add(after.steps[after.step_index].primary_object)
        belief = after.belief
        if after.phase is Phase.EXECUTE and belief is not None and belief.estimate is not None:
            executed, doubted = belief.estimate.executed.as_dict, belief.estimate.doubted
            for assist in after.assists:
                pair = (assist.source_id, assist.target_id)
                fits = executed.get(pair[0]) == pair[1] and (
                    doubted is None or (doubted.source_id, doubted.target_id) != pair
                )
                corrected = assist.confirmed and pair[0] in asked_about
                assert fits or pair in asked or corrected, (pair, executed)


def test_the_walks_above_reach_execution_with_assists_confirmed_and_left_unconfirmed():
    plain = confirmed = unconfirmed = 0
    for seed, start in enumerate(STARTS * 2):
        for _, _, outcome in random_walk(np.random.default_rng(seed), 4000, start, n=4, led=0.5):
            after = outcome.dialogue
            if after.phase is Phase.EXECUTE:
                confirmed += any(a.confirmed for a in after.assists)
                unconfirmed += bool(after.kept_unconfirmed)
                plain += not after.kept_unconfirmed and any(not a.confirmed for a in after.assists)
    assert min(plain, confirmed, unconfirmed) > 0, (plain, confirmed, unconfirmed)


def test_a_doubted_assist_is_asked_about_when_it_would_go_on_and_not_before():
    conversation = doubting()
    prompt = conversation.prompts[-1]
    assert (prompt.kind, prompt.step_index, prompt.source_id, prompt.target_ids) == (
        PromptKind.CONFIRM_ASSIST,
        0,
        "s1",
        ("t3",),
    )
    assert prompt.text == "You gave me t3 for s1: is that so?"
    assert conversation.dialogue.awaiting is Awaited.CONFIRMATION

    unsure = Conversation().until(Phase.ASSIST)
    infer(unsure, 0.0)
    unsure.answer("t3")
    infer(unsure, 0.0, doubted=unsure.dialogue.assists[0], doubt=0.7)
    assert unsure.prompts[-1].kind is PromptKind.WHERE_DO_I_GO


def test_yes_makes_it_certain_and_it_is_not_asked_again():
    conversation = doubting()
    assert conversation.do(Signal.YES)
    assert [(a.target_id, a.confirmed) for a in conversation.published[-1].assists] == [("t3", True), ("t2", False)]
    infer(conversation, 0.5)
    assert conversation.dialogue.phase is Phase.EXECUTE
    assert "pick t3 for s1" in conversation.prompts[-1].text or conversation.dialogue.assists[0].target_id == "t3"


def test_no_withdraws_it_keeps_the_no_as_evidence_and_asks_its_step_again_however_confident():
    conversation = doubting()
    assert conversation.do(Signal.NO)
    published = conversation.published[-1]
    assert [a.source_id for a in published.assists] == ["s2"]
    assert [(d.source_id, d.target_id, d.step_index) for d in published.denials] == [("s1", "t3", 0)]
    infer(conversation, 0.9)
    assert conversation.prompts[-1].kind is PromptKind.WHAT_DO_I_USE and conversation.prompts[-1].source_id == "s1"
    assert conversation.answer("t1")
    assert [(a.source_id, a.confirmed) for a in conversation.dialogue.assists] == [("s2", False), ("s1", True)]
    infer(conversation, 0.9)
    assert conversation.dialogue.phase is Phase.EXECUTE


def test_another_object_instead_overwrites_it_for_certain():
    conversation = doubting()
    assert conversation.answer("t1", Signal.HANDED)
    assert conversation.pairs == [("s1", "t1"), ("s2", "t2")]
    assert conversation.dialogue.assists[0].confirmed


def test_the_same_object_again_is_a_yes():
    conversation = doubting()
    assert conversation.answer("t3", Signal.HANDED)
    assert conversation.dialogue.assists[0].confirmed


def test_an_object_instead_may_be_handed_over_or_pointed_at_whatever_the_step():
    for signal in (Signal.HANDED, Signal.POINTED):
        conversation = doubting()
        assert conversation.answer("t1", signal) and conversation.pairs[0] == ("s1", "t1")


@pytest.mark.parametrize("answer", [Signal.YES, Signal.NO, "t1", "t3"])
def test_undo_takes_the_answer_back_and_it_is_asked_again(answer: Signal | str):
    conversation = doubting()
    before = conversation.dialogue
    assert conversation.do(answer) if isinstance(answer, Signal) else conversation.answer(answer, Signal.HANDED)
    assert conversation.do(Signal.UNDO)
    assert (conversation.dialogue.assists, conversation.dialogue.denials) == (before.assists, before.denials)
    infer(conversation, 0.5, doubted=conversation.dialogue.assists[0], doubt=0.7)
    assert conversation.prompts[-1].kind is PromptKind.CONFIRM_ASSIST
    assert conversation.do(Signal.UNDO) and conversation.pairs == [("s1", "t3")]


def test_skipped_it_holds_as_given_and_is_executed_though_doubted():
    conversation = doubting()
    doubted = conversation.dialogue.assists[0]
    best = Mapping((("s1", "t1"), ("s2", "t2")), 0.6)
    infer(conversation, 0.5, mapping=best, doubted=doubted, doubt=0.7)
    assert conversation.do(Signal.SKIP)
    assert conversation.dialogue.phase is Phase.EXECUTE
    assert conversation.dialogue.assists[0] == doubted
    assert conversation.prompts[-1].text.startswith("I do as you told me, though I doubt it (0.2).")


def test_a_mapping_that_does_not_hold_an_assist_is_asked_about_though_nothing_is_doubted():
    """As when two objects were given for one another's part, or by a strategy that names no doubt."""
    conversation = Conversation().until(Phase.ASSIST)
    infer(conversation, 0.0)
    conversation.answer("t3")
    infer(conversation, 0.5, obeying=Mapping((("s1", "t1"), ("s3", "t3")), 0.5))
    assert conversation.prompts[-1].kind is PromptKind.CONFIRM_ASSIST
    assert conversation.prompts[-1].target_ids == ("t3",)


def test_while_executing_an_estimate_against_an_assist_leads_back_to_the_question():
    conversation = Conversation().until(Phase.ASSIST)
    infer(conversation, 0.0)
    conversation.answer("t1")
    infer(conversation, 0.5)
    assert conversation.dialogue.phase is Phase.EXECUTE
    infer(conversation, 0.5, obeying=Mapping((("s1", "t4"),), 0.5))
    assert conversation.dialogue.phase is Phase.ASSIST
    assert conversation.prompts[-1].kind is PromptKind.CONFIRM_ASSIST


def test_yes_to_is_this_it_is_an_assist_and_no_is_kept_and_not_asked_again():
    said_yes, said_no = (naming(QuestionKind.IS_THIS_IT, "t2") for _ in range(2))
    assert said_yes.prompts[-1].text == "Is t2 the one for s1? (step 1)"
    assert said_yes.do(Signal.YES) and said_yes.pairs == [("s1", "t2")]
    assert said_no.do(Signal.NO) and said_no.pairs == []
    assert [(d.source_id, d.target_id) for d in said_no.published[-1].denials] == [("s1", "t2")]
    infer(said_no, 0.0, next_question="s1", question_kind=QuestionKind.IS_THIS_IT, question_targets=("t2",))
    assert said_no.prompts[-1].kind is PromptKind.WHAT_DO_I_USE


def test_which_of_two_takes_one_of_them_another_or_neither_but_no_yes():
    one, other, neither = (naming(QuestionKind.WHICH_OF_TWO, "t2", "t3") for _ in range(3))
    assert one.prompts[-1].text == "Which is the one for s1: t2 or t3? (step 1)"
    assert not one.do(Signal.YES) and "answer t2 or t3 on wizard/handed" in one.reasons[-1]
    assert one.answer("t3", Signal.HANDED) and one.pairs == [("s1", "t3")]
    assert other.answer("t4", Signal.HANDED) and other.pairs == [("s1", "t4")]
    assert neither.do(Signal.NO)
    assert {(d.source_id, d.target_id) for d in neither.dialogue.denials} == {("s1", "t2"), ("s1", "t3")}


def test_questions_that_name_objects_are_asked_only_where_allowed_and_of_known_objects():
    conversation = Conversation().until(Phase.ASSIST)
    infer(conversation, 0.0, next_question="s1", question_kind=QuestionKind.IS_THIS_IT, question_targets=("t2",))
    assert conversation.prompts[-1].kind is PromptKind.WHAT_DO_I_USE
    assert naming(QuestionKind.IS_THIS_IT, "t99").prompts[-1].kind is PromptKind.WHAT_DO_I_USE
    assert naming(QuestionKind.WHICH_OF_TWO, "t2").prompts[-1].kind is PromptKind.WHAT_DO_I_USE


def test_a_no_can_be_undone_and_an_assist_that_claims_it_after_all_takes_its_place():
    conversation = naming(QuestionKind.IS_THIS_IT, "t2")
    conversation.do(Signal.NO)
    assert conversation.do(Signal.UNDO) and conversation.dialogue.denials == ()
    infer(conversation, 0.5)
    assert conversation.dialogue.step_index == 0, "its step is asked again, however confident"
    conversation = naming(QuestionKind.IS_THIS_IT, "t2")
    conversation.do(Signal.NO)
    infer(conversation, 0.0)
    conversation.answer("t2")
    assert conversation.dialogue.denials == () and conversation.pairs == [("s1", "t2")]


def test_yes_or_no_to_an_older_question_is_late():
    conversation = doubting()
    late = Event(Signal.YES, conversation.dialogue.asked_at - SECOND, "wizard/answer")
    assert not conversation.accepted(late) and "late" in conversation.reasons[-1]


def came_back(conversation: Conversation) -> Dialogue:
    """The dialogue of a node that was killed, with its latched inputs received again but for the estimate."""
    before = conversation.dialogue
    again = restored(before.state, before.assists_stamp, before.config)
    for event in (
        TaskReceived(Signal.TASK, conversation.tick(), task=before.task, stamp=before.task_stamp),
        TargetReceived(Signal.TARGET, conversation.tick(), scene=before.target, stamp=before.target_stamp),
    ):
        again = transition(again, event).dialogue
    conversation.dialogue = again
    return before


def test_a_node_that_comes_back_asks_the_same_question_about_an_assist():
    conversation = doubting()
    before = came_back(conversation)
    infer(conversation, 0.5, doubted=conversation.dialogue.assists[0], doubt=0.7)
    assert conversation.dialogue.state == before.state


def test_a_node_that_comes_back_knows_what_was_confirmed_and_denied_and_skipped():
    conversation = doubting(NAMING)
    conversation.do(Signal.YES)
    infer(conversation, 0.0, next_question="s4", question_kind=QuestionKind.IS_THIS_IT, question_targets=("t1",))
    conversation.do(Signal.NO)
    infer(conversation, 0.0)
    conversation.do(Signal.SKIP)
    before = came_back(conversation)
    infer(conversation, 0.0)
    assert conversation.dialogue.state == before.state
    assert [a.confirmed for a in conversation.dialogue.assists] == [True, False]
    assert [replace(d, stamp=0.0) for d in conversation.dialogue.denials] == [Denial("s4", "t1", 4)]


def test_a_node_that_comes_back_can_undo_a_no():
    conversation = naming(QuestionKind.WHICH_OF_TWO, "t2", "t3")
    conversation.do(Signal.NO)
    came_back(conversation)
    assert conversation.do(Signal.UNDO) and conversation.dialogue.denials == ()
