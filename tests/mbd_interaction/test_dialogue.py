"""The dialogue takes a session from the source table to the end, asking only what it needs."""

from __future__ import annotations

import dataclasses

import pytest
from mbd_interaction import events
from mbd_interaction.dialogue import Call, Deed, Dialogue, DialogueConfig, Outcome, PublishAssists, QuestionOrder, Say
from mbd_interaction.events import Event, Signal
from mbd_interaction.restoring import restored
from mbd_interaction.synthetic import SECOND, estimate_for, results, true_target
from mbd_interaction.transitions import transition
from mbd_model.session import Phase, Prompt, PromptKind

N = 4


class Conversation:
    """A dialogue whose other nodes do well; time goes on a second with each event."""

    def __init__(self, *, confidence: float = 0.0, config: DialogueConfig | None = None) -> None:
        self.dialogue = Dialogue("test", config=config or DialogueConfig())
        self.confidence = confidence
        self.now = SECOND
        self.prompts: list[Prompt] = []
        self.published: list[PublishAssists] = []
        self.reasons: list[str] = []

    def feed(self, event: Event) -> Outcome:
        before = self.dialogue
        outcome = transition(self.dialogue, event)
        self.dialogue = outcome.dialogue
        self.prompts += [e.prompt for e in outcome.effects if isinstance(e, Say)]
        self.published += [e for e in outcome.effects if isinstance(e, PublishAssists)]
        self.reasons += [outcome.reply.reason] if outcome.reply else []
        for answer in results(before, outcome.effects, self.tick(), N):
            later = self.feed(answer)
            outcome = later if later.reply else outcome
        return outcome

    def tick(self) -> int:
        self.now += SECOND
        return self.now

    def do(self, signal: Signal) -> bool:
        return self.accepted(Event(signal, self.tick(), "wizard/command"))

    def answer(self, object_id: str, signal: Signal | None = None) -> bool:
        kind = self.prompts[-1].kind
        signal = signal or (Signal.HANDED if kind is PromptKind.WHAT_DO_I_USE else Signal.POINTED)
        return self.accepted(events.Answered(signal, self.tick(), f"wizard/{signal}", object_id))

    def point(self, *place: float) -> bool:
        x, y, z = place
        return self.accepted(events.Answered(Signal.POINTED, self.tick(), "wizard/pointed", "", (x, y, z)))

    def mean(self, step_index: int, object_id: str) -> bool:
        event = events.Overwritten(Signal.OVERWRITE, self.tick(), "wizard/overwrite", step_index, object_id)
        return self.accepted(event)

    def accepted(self, event: Event) -> bool:
        outcome = self.feed(event)
        assert outcome.reply is not None and outcome.reply.reason
        return outcome.reply.accepted

    def infer(self, confidence: float | None = None) -> None:
        self.feed(estimate_for(self.dialogue, self.tick(), self.confidence if confidence is None else confidence))

    def until(self, phase: Phase) -> Conversation:
        order = [Signal.NEXT_PHASE, Signal.START, Signal.STOP, Signal.NEXT_PHASE, Signal.NEXT_PHASE]
        for signal in order:
            if self.dialogue.phase is phase and signal is not Signal.STOP:
                break
            assert self.do(signal), self.reasons[-1]
        assert self.dialogue.phase is phase
        return self

    @property
    def pairs(self) -> list[tuple[str, str]]:
        return [(a.source_id, a.target_id) for a in self.dialogue.assists]


@pytest.fixture
def asking() -> Conversation:
    """The first question, of step 0 (pick s1), is asked."""
    conversation = Conversation().until(Phase.ASSIST)
    conversation.infer()
    return conversation


def test_a_session_goes_through_its_phases_to_the_end():
    session = Conversation().until(Phase.ASSIST)
    while session.dialogue.phase is Phase.ASSIST:
        session.infer(0.0)
        if session.dialogue.phase is Phase.ASSIST:
            assert session.answer(true_target(session.prompts[-1].source_id)), session.reasons[-1]
    assert session.dialogue.phase is Phase.CARRY_ON
    assert session.pairs == [("s1", "t1"), ("s2", "t2"), ("s3", "t3"), ("s4", "t4")]
    assert session.do(Signal.NEXT_PHASE) and session.dialogue.phase is Phase.DONE


def test_nothing_is_asked_when_the_first_estimate_is_confident():
    session = Conversation().until(Phase.ASSIST)
    session.infer(0.3)
    assert session.dialogue.phase is Phase.CARRY_ON
    assert all(p.kind is PromptKind.INFORM for p in session.prompts)


def test_asking_stops_when_an_assist_makes_it_confident(asking: Conversation):
    asking.answer("t1")
    asking.infer(0.08)
    assert asking.dialogue.phase is Phase.CARRY_ON
    said = asking.prompts[-1]
    assert said.kind is PromptKind.INFORM
    assert said.text.startswith("I am confident (0.08). I go on alone: step 2 place onto t2 for s2; step 3 pick t3 for")
    assert asking.dialogue.step_index == 1


def test_the_two_questions_are_the_papers(asking: Conversation):
    assert asking.prompts[-1].kind is PromptKind.WHAT_DO_I_USE
    assert asking.prompts[-1].text.startswith("What do I use now?")
    asking.answer("t1")
    asking.infer()
    assert asking.prompts[-1].kind is PromptKind.WHERE_DO_I_GO
    assert asking.prompts[-1].text.startswith("Where do I go next?")


def test_an_object_told_once_is_not_asked_about_again(asking: Conversation):
    """Steps 0 and 3 name s1: picked first, then s3 is placed onto it."""
    for target in ("t1", "t2", "t3"):
        asking.answer(target)
        asking.infer()
    assert asking.dialogue.steps[3].primary_object == "s1"
    assert asking.dialogue.step_index == 4


def test_only_the_estimate_of_the_present_assists_counts(asking: Conversation):
    stale = estimate_for(asking.dialogue, asking.tick(), 0.5)
    asking.answer("t1")
    asking.feed(stale)
    assert asking.dialogue.phase is Phase.ASSIST and asking.dialogue.step_index == -1


def test_an_estimate_that_comes_before_its_inputs_are_heard_still_counts():
    session = Conversation().until(Phase.ASSIST)
    whole, task = session.dialogue, session.dialogue.task
    session.dialogue = dataclasses.replace(whole, task=None, task_stamp=0)
    session.feed(estimate_for(whole, session.tick(), 0.0))
    session.feed(events.TaskHeard(Signal.TASK, session.tick(), task=task, stamp=whole.task_stamp))
    assert session.dialogue.step_index == 0


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


def test_while_a_deed_is_under_way_other_events_wait():
    first = transition(Dialogue("test"), Event(Signal.NEXT_PHASE, 1, "wizard/command"))
    assert first.effects == (Call(Deed.OBSERVE_SOURCE, 1),) and first.reply is None
    second = transition(first.dialogue, Event(Signal.NEXT_PHASE, 2, "wizard/command"))
    assert second.reply and not second.reply.accepted and "still busy" in second.reply.reason
    assert second.dialogue == first.dialogue


def test_a_failed_look_stays_in_its_phase_and_answers_why():
    asked = transition(Dialogue("test"), Event(Signal.NEXT_PHASE, 1, "wizard/command")).dialogue
    failed = events.DeedDone(Signal.DEED_DONE, 5, token=1, success=False, message="no table in view")
    outcome = transition(asked, failed)
    assert outcome.dialogue.phase is Phase.OBSERVE_SOURCE
    assert outcome.reply and (outcome.reply.stamp, outcome.reply.accepted) == (1, False)
    assert outcome.reply.reason == "no table in view"


def test_a_result_nobody_waits_for_changes_nothing():
    dialogue = Dialogue("test")
    late = events.DeedDone(Signal.DEED_DONE, 5, token=0, success=True)
    assert transition(dialogue, late) == Outcome(dialogue)


def test_a_demonstration_that_shows_nothing_can_be_started_again():
    session = Conversation().until(Phase.DEMONSTRATE)
    session.do(Signal.START)
    stopping = transition(session.dialogue, Event(Signal.STOP, session.tick(), "wizard/demonstration")).dialogue
    why = "no step was demonstrated: the gripper never closed"
    session.dialogue = stopping
    session.feed(events.DeedDone(Signal.DEED_DONE, session.tick(), token=stopping.token, success=False, message=why))
    assert session.dialogue.phase is Phase.DEMONSTRATE and session.reasons[-1] == why
    assert session.do(Signal.START)


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


def test_the_most_informative_step_is_asked_first_when_wanted():
    session = Conversation(config=DialogueConfig(question_order=QuestionOrder.INFORMATIVE)).until(Phase.ASSIST)
    session.infer()
    assert session.dialogue.step_index == 4  # the step of s4, which the estimate names as the next question


def test_a_missing_estimate_is_asked_about():
    session = Conversation().until(Phase.ASSIST)
    session.feed(Event(Signal.OVERDUE, session.tick()))
    assert "are the mapping and demonstration nodes running?" in session.prompts[-1].text


def test_a_dialogue_that_comes_back_carries_on(asking: Conversation):
    asking.do(Signal.SKIP)
    asking.answer("t2")
    asking.infer()
    before = asking.dialogue
    asking.dialogue = restored(before.state, before.assists_stamp, before.config)
    asking.feed(events.TaskHeard(Signal.TASK, asking.tick(), task=before.task, stamp=before.task_stamp))
    asking.feed(events.TargetHeard(Signal.TARGET, asking.tick(), scene=before.target, stamp=before.target_stamp))
    asking.infer()
    assert asking.dialogue.state == before.state
