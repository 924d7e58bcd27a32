"""What the robot needs a person for while it works: asked in one sentence, answered by yes, no, skip or an object."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mbd_interaction import events
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import PublishAssists, PublishPrompt
from mbd_interaction.events import Event, Signal
from mbd_interaction.phases.help_requests import BY_OBJECT
from mbd_interaction.restore import restored
from mbd_interaction.synthetic import SECOND, awaited_event, estimate_for
from mbd_interaction.transitions import transition
from mbd_model.execution_progress import Failure, Status, Verdict
from mbd_model.session import Awaited, Phase, PromptKind

from tests.mbd_interaction.test_execution_phase import executing

LATER = 10**5 * SECOND
HELPED = [f for f in Failure if f not in BY_OBJECT]


def failed(dialogue: Dialogue, failure: Failure, step: int = 2) -> Outcome:
    stamp = dialogue.assists_stamp
    event = events.ProgressReceived(Signal.PROGRESS, LATER, "", step, Status.FAILED, "t1 fell", stamp, failure)
    return transition(dialogue, event)


def then(dialogue: Dialogue, signal: Signal) -> Outcome:
    return transition(dialogue, Event(signal, LATER + SECOND, "wizard/answer"))


def inferred(dialogue: Dialogue) -> Dialogue:
    return transition(dialogue, estimate_for(dialogue, LATER + 2 * SECOND, 0.9)).dialogue


@pytest.mark.parametrize("failure", HELPED)
def test_each_failure_is_asked_about_and_withdraws_no_assist(failure: Failure):
    before = executing()
    outcome = failed(before, failure)
    asked = outcome.dialogue
    assert (asked.phase, asked.awaiting, asked.step_index) == (Phase.ASSIST, Awaited.HELP, 2)
    assert asked.assists == before.assists
    prompts = [e.prompt for e in outcome.effects if isinstance(e, PublishPrompt)]
    assert [p.kind for p in prompts] == [PromptKind.PUT_IT_RIGHT] and "t1 fell" in prompts[0].text


@pytest.mark.parametrize(("signal", "verdict"), [(Signal.YES, Verdict.YES), (Signal.NO, Verdict.NO)])
def test_yes_and_no_lead_back_to_the_work_with_a_verdict_under_a_new_stamp(signal: Signal, verdict: Verdict):
    asked = failed(executing(), Failure.WHICH_ONE).dialogue
    outcome = then(asked, signal)
    assert outcome.reply is not None and outcome.reply.accepted
    assert any(isinstance(e, PublishAssists) and e.stamp > asked.assists_stamp for e in outcome.effects)
    after = inferred(outcome.dialogue)
    assert (after.phase, after.verdict, after.state.verdict) == (Phase.EXECUTE, verdict, verdict)
    assert after.assists == asked.assists


def test_skip_leads_back_to_the_work_without_a_verdict():
    outcome = then(failed(executing(), Failure.NOT_THERE).dialogue, Signal.SKIP)
    after = inferred(outcome.dialogue)
    assert (after.phase, after.verdict) == (Phase.EXECUTE, Verdict.NONE) and 2 in after.skipped


def test_another_object_becomes_an_assist_and_the_one_in_use_is_the_same_as_yes():
    asked = failed(executing(), Failure.NOT_THERE, step=0).dialogue
    source = asked.steps[0].primary_object
    used = asked.belief.estimate.executed.as_dict[source]
    same = events.Answered(Signal.HANDED, LATER + SECOND, "wizard/handed", used)
    assert transition(asked, same).dialogue.assists == asked.assists
    other = next(t for t in asked.target.ids if t != used)
    outcome = transition(asked, replace(same, object_id=other))
    assert [a.target_id for a in outcome.dialogue.assists if a.source_id == source] == [other]


def test_a_question_is_put_again_when_the_node_comes_back_amid_it():
    asked = failed(executing(), Failure.NOT_THERE).dialogue
    again = restored(asked.state, asked.assists_stamp, asked.config)
    assert again.phase is Phase.ASSIST and again.verdict is Verdict.NONE


def test_an_estimate_or_a_pause_does_not_answer_for_the_teacher():
    asked = failed(executing(), Failure.FALLEN_OVER).dialogue
    assert transition(asked, estimate_for(asked, LATER + SECOND, 0.9)).dialogue.awaiting is Awaited.HELP
    paused = then(asked, Signal.PAUSE).dialogue
    assert then(paused, Signal.RESUME).dialogue.awaiting is Awaited.HELP


def test_what_is_awaited_then_is_a_yes():
    asked = failed(executing(), Failure.NOT_SEEN).dialogue
    event = awaited_event(asked, LATER, 3)
    assert event is not None and event.signal is Signal.YES


@pytest.mark.parametrize("step", [0, 1, 2, 3])
def test_not_that_one_leaves_the_work_at_once_denies_the_object_in_use_and_maps_again(step: int):
    before = executing()
    progress = events.ProgressReceived(Signal.PROGRESS, LATER, "", step, Status.UNDER_WAY, "", before.assists_stamp)
    under_way = transition(before, progress).dialogue
    source = under_way.steps[step].primary_object
    used = under_way.belief.estimate.executed.as_dict[source]
    outcome = then(under_way, Signal.NO)
    after = outcome.dialogue
    assert outcome.reply is not None and outcome.reply.accepted
    assert after.phase is Phase.ASSIST  # whatever is inferred next: the robot stops by the phase
    assert (source, used) in [(d.source_id, d.target_id) for d in after.denials]
    assert (source, used) not in [(a.source_id, a.target_id) for a in after.assists]
    assert any(isinstance(e, PublishAssists) for e in outcome.effects)


def test_not_that_one_is_refused_while_the_robot_is_at_no_step():
    reply = then(executing(), Signal.NO).reply
    assert reply is not None and not reply.accepted and "wizard/overwrite" in reply.reason
