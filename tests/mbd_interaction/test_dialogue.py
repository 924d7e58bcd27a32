"""The dialogue takes a session from the source table to the end, asking only what it needs."""

from __future__ import annotations

import dataclasses

from dialogue_conversation import Conversation
from mbd_interaction import events
from mbd_interaction.config import DialogueConfig, QuestionOrder
from mbd_interaction.events import Event, Signal
from mbd_interaction.restore import restored
from mbd_interaction.synthetic import estimate_for, true_target
from mbd_model.session import Phase, PromptKind


def test_a_session_goes_through_its_phases_to_the_end():
    session = Conversation().until(Phase.ASSIST)
    while session.dialogue.phase is Phase.ASSIST:
        session.infer(0.0)
        if session.dialogue.phase is Phase.ASSIST:
            assert session.answer(true_target(session.prompts[-1].source_id)), session.reasons[-1]
    assert session.dialogue.phase is Phase.EXECUTE
    assert session.pairs == [("s1", "t1"), ("s2", "t2"), ("s3", "t3"), ("s4", "t4")]
    assert session.do(Signal.NEXT_PHASE) and session.dialogue.phase is Phase.DONE


def test_nothing_is_asked_when_the_first_estimate_is_confident():
    session = Conversation().until(Phase.ASSIST)
    session.infer(0.3)
    assert session.dialogue.phase is Phase.EXECUTE
    assert all(p.kind is PromptKind.INFORM for p in session.prompts)


def test_asking_stops_when_an_assist_makes_it_confident(in_assist_phase: Conversation):
    in_assist_phase.answer("t1")
    in_assist_phase.infer(0.08)
    assert in_assist_phase.dialogue.phase is Phase.EXECUTE
    prompt = in_assist_phase.prompts[-1]
    assert prompt.kind is PromptKind.INFORM
    assert prompt.text.startswith(
        "I am confident (0.08). I go on alone: step 2 place onto t2 for s2; step 3 pick t3 for"
    )
    assert in_assist_phase.dialogue.step_index == 1


def test_the_two_questions_are_the_papers(in_assist_phase: Conversation):
    assert in_assist_phase.prompts[-1].kind is PromptKind.WHAT_DO_I_USE
    assert in_assist_phase.prompts[-1].text.startswith("What do I use now?")
    in_assist_phase.answer("t1")
    in_assist_phase.infer()
    assert in_assist_phase.prompts[-1].kind is PromptKind.WHERE_DO_I_GO
    assert in_assist_phase.prompts[-1].text.startswith("Where do I go next?")


def test_an_object_assisted_once_is_not_asked_about_again(in_assist_phase: Conversation):
    """Steps 0 and 3 name s1: picked first, then s3 is placed onto it."""
    for target in ("t1", "t2", "t3"):
        in_assist_phase.answer(target)
        in_assist_phase.infer()
    assert in_assist_phase.dialogue.steps[3].primary_object == "s1"
    assert in_assist_phase.dialogue.step_index == 4


def test_only_the_estimate_of_the_present_assists_counts(in_assist_phase: Conversation):
    stale = estimate_for(in_assist_phase.dialogue, in_assist_phase.tick(), 0.5)
    in_assist_phase.answer("t1")
    in_assist_phase.feed(stale)
    assert in_assist_phase.dialogue.phase is Phase.ASSIST and in_assist_phase.dialogue.step_index == -1


def test_an_estimate_that_comes_before_its_inputs_are_received_still_counts():
    session = Conversation().until(Phase.ASSIST)
    complete, task = session.dialogue, session.dialogue.task
    session.dialogue = dataclasses.replace(complete, task=None, task_stamp=0)
    session.feed(estimate_for(complete, session.tick(), 0.0))
    session.feed(events.TaskReceived(Signal.TASK, session.tick(), task=task, stamp=complete.task_stamp))
    assert session.dialogue.step_index == 0


def test_the_most_informative_step_is_asked_first_when_wanted():
    session = Conversation(config=DialogueConfig(question_order=QuestionOrder.INFORMATIVE)).until(Phase.ASSIST)
    session.infer()
    assert session.dialogue.step_index == 4  # the step of s4, which the estimate names as the next question


def test_a_missing_estimate_is_asked_about():
    session = Conversation().until(Phase.ASSIST)
    session.feed(Event(Signal.OVERDUE, session.tick()))
    assert "are the mapping and demonstration nodes running?" in session.prompts[-1].text


def test_a_dialogue_that_comes_back_continues(in_assist_phase: Conversation):
    in_assist_phase.do(Signal.SKIP)
    in_assist_phase.answer("t2")
    in_assist_phase.infer()
    before = in_assist_phase.dialogue
    in_assist_phase.dialogue = restored(before.state, before.assists_stamp, before.config)
    in_assist_phase.feed(
        events.TaskReceived(Signal.TASK, in_assist_phase.tick(), task=before.task, stamp=before.task_stamp)
    )
    in_assist_phase.feed(
        events.TargetReceived(Signal.TARGET, in_assist_phase.tick(), scene=before.target, stamp=before.target_stamp)
    )
    in_assist_phase.infer()
    assert in_assist_phase.dialogue.state == before.state
