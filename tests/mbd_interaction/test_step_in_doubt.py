"""A demonstrated step in doubt is asked about while the table still shows it; the answer corrects the task."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from dialogue_conversation import Conversation
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.geometry.judging import tie
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose
from mbd_interaction import events
from mbd_interaction.config import DialogueConfig
from mbd_interaction.effects import Call, Request
from mbd_interaction.events import Event, Signal, TaskReceived
from mbd_interaction.restore import restored
from mbd_interaction.synthetic import doubtful_task
from mbd_interaction.transitions import transition
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.objects import SceneObject
from mbd_model.session import Awaited, Phase, PromptKind
from mbd_model.task import Task
from mbd_msgs import msg as m

COLORS = {"s1": "red", "s2": "blue", "s3": "green", "s4": "yellow"}


def colored(task: Task) -> Task:
    """Its objects are cups of a colour each, so that people can tell them apart."""

    def cup(thing: SceneObject) -> SceneObject:
        return replace(thing, color_name=COLORS[thing.object_id], object_class="cup")

    return replace(task, source=replace(task.source, objects=tuple(cup(o) for o in task.source.objects)))


def shown(*doubtful: int, config: DialogueConfig | None = None) -> Conversation:
    """A dialogue after a demonstration, steps of which are in doubt."""
    conversation = Conversation(config=config).until(Phase.DEMONSTRATE)
    assert conversation.do(Signal.START) and conversation.do(Signal.STOP)
    show(conversation, colored(doubtful_task(4, *doubtful)))
    return conversation


def show(conversation: Conversation, task: Task) -> None:
    at = conversation.tick()
    conversation.feed(TaskReceived(Signal.TASK, at, task=task, stamp=at))


def calls(conversation: Conversation, event: Event) -> list[Call]:
    """What an event has done, without anybody doing it."""
    outcome = transition(conversation.dialogue, event)
    assert outcome.reply is None or outcome.reply.accepted, outcome.reply
    return [e for e in outcome.effects if isinstance(e, Call)]


def test_it_asks_which_of_the_two_in_words_for_people():
    conversation = shown(0, 3)
    prompt = conversation.prompts[-1]
    assert prompt.kind is PromptKind.WHICH_WAS_MEANT and prompt.step_index == 0
    assert prompt.text == "Did you pick the red cup or the blue cup? (step 1)"
    assert prompt.source_ids == ("s1", "s2") and prompt.target_ids == ()
    assert conversation.dialogue.phase is Phase.TUCK_AND_CLEAR


def test_a_place_in_doubt_is_asked_about_by_what_it_was_put_onto():
    assert shown(1).prompts[-1].text == "Did you put it onto the blue cup or the red cup? (step 2)"


def test_a_step_that_is_hardly_in_doubt_is_not_asked_about():
    assert shown().prompts[-1].kind is PromptKind.INFORM
    assert shown(0, config=DialogueConfig(doubt_asked=0.31)).prompts[-1].kind is PromptKind.INFORM


def test_a_near_tie_of_two_millimetres_is_asked_about_and_a_centimetre_is_not():
    """As the demonstration judges a step: the tool was 10 mm from one cup and a little more from the other."""
    plain = doubtful_task(4)
    tool = ToolPose(np.array([0.5, 0.3, 0.1]), np.array([0.0, 0.0, 0.0, 1.0]))
    for margin, asked in ((0.0, True), (0.002, True), (0.01, False)):
        workspace = TrackedObjects.before(plain.source)
        doubt = tie(workspace, tool, [(0.010, "s1"), (0.010 + margin, "s2")], StepSegmentationConfig())
        conversation = shown()
        steps = (replace(plain.steps[0], doubt=doubt), *plain.steps[1:])
        show(conversation, colored(replace(plain, steps=steps)))
        assert (conversation.prompts[-1].kind is PromptKind.WHICH_WAS_MEANT) is asked, margin


def test_the_state_keeps_the_words_of_the_demonstration_for_a_recorder_that_comes_back():
    conversation = Conversation().until(Phase.DEMONSTRATE)

    def grip(close: bool) -> None:
        event = events.Gripped(Signal.GRIPPER, conversation.tick(), "wizard/gripper", close)
        assert conversation.accepted(event)

    grip(True)  # for the hand only
    assert conversation.do(Signal.START)
    for close in (True, False):
        grip(close)
    state = conversation.dialogue.state
    assert [w.close for w in state.words] == [True, False]
    assert restored(state, 0, conversation.dialogue.config).words == state.words
    assert conversation.do(Signal.STOP)
    assert conversation.dialogue.state.words == ()


def test_either_answer_has_the_step_corrected_and_the_next_one_in_doubt_is_asked_about():
    for object_id, signal in (("s1", Signal.HANDED), ("s2", Signal.POINTED)):
        conversation = shown(0, 3)
        answer = events.Answered(signal, conversation.tick(), f"wizard/{signal}", object_id)
        assert calls(conversation, answer) == [
            Call(
                Request.REVISE,
                conversation.dialogue.token + 1,
                StepCorrection(CorrectionKind.CHANGE_OBJECT, 0, 0, object_id),
            )
        ]
        assert conversation.accepted(answer)
        show(conversation, colored(doubtful_task(4, 3)))
        assert conversation.prompts[-1].step_index == 3
        show(conversation, colored(doubtful_task(4)))
        assert conversation.prompts[-1].kind is PromptKind.INFORM
        assert conversation.dialogue.step_index == -1


def test_skip_leaves_a_step_in_doubt_and_asks_about_the_next():
    conversation = shown(0, 3)
    assert conversation.do(Signal.SKIP) and "stays in doubt (30%)" in conversation.reasons[-1]
    assert conversation.prompts[-1].step_index == 3
    assert conversation.do(Signal.SKIP)
    assert conversation.dialogue.question is None
    assert not conversation.do(Signal.SKIP)
    show(conversation, colored(doubtful_task(4, 0, 3)))  # as after a correction of another step
    assert conversation.dialogue.question is None


def test_the_session_goes_on_without_an_answer():
    conversation = shown(0)
    assert conversation.dialogue.awaiting is Awaited.NEXT_PHASE
    assert conversation.do(Signal.NEXT_PHASE)
    assert conversation.dialogue.phase is Phase.OBSERVE_TARGET and conversation.dialogue.step_index == -1


def test_what_is_neither_of_the_two_is_refused_with_both_names():
    conversation = shown(0)
    for object_id in ("s3", "t1", ""):
        assert not conversation.answer(object_id, Signal.POINTED)
        assert "name s1 or s2" in conversation.reasons[-1]


def test_a_node_that_comes_back_asks_again():
    before = shown(0)
    again = restored(before.dialogue.state, before.dialogue.assists_stamp, before.dialogue.config)
    assert again.step_index == -1
    event = TaskReceived(Signal.TASK, before.tick(), task=before.dialogue.task, stamp=before.dialogue.task_stamp)
    assert transition(again, event).dialogue.question == before.dialogue.question


def revision(conversation: Conversation, kind: CorrectionKind, step: int = 0) -> Event:
    return events.Revised(Signal.REVISE, conversation.tick(), "wizard/revision", StepCorrection(kind, step))


def test_recording_again_goes_back_to_the_demonstration_and_is_under_way_at_once():
    conversation = shown()
    assert conversation.accepted(revision(conversation, CorrectionKind.RERECORD, 2))
    assert (conversation.dialogue.phase, conversation.dialogue.recording) == (Phase.DEMONSTRATE, True)
    assert conversation.do(Signal.STOP)
    assert conversation.dialogue.phase is Phase.TUCK_AND_CLEAR


def test_a_request_under_way_when_the_session_is_aborted_answers_its_event_too():
    conversation = shown()
    event = revision(conversation, CorrectionKind.DELETE)
    waiting = transition(conversation.dialogue, event).dialogue
    aborted = transition(waiting, Event(Signal.ABORT, conversation.tick(), "wizard/command"))
    assert aborted.reply is not None and aborted.reply.accepted
    done = events.RequestDone(Signal.REQUEST_DONE, conversation.tick(), "", waiting.token, True, "done")
    outcome = transition(aborted.dialogue, done)
    assert outcome.reply is not None and (outcome.reply.stamp, outcome.reply.accepted) == (event.at, False)
    assert outcome.dialogue.phase is Phase.ABORTED and outcome.dialogue.pending is None
    assert transition(outcome.dialogue, done).reply is None


def test_nothing_is_recorded_again_once_the_table_is_cleared():
    conversation = shown()
    assert conversation.do(Signal.NEXT_PHASE)
    assert not conversation.accepted(revision(conversation, CorrectionKind.RERECORD))
    assert "off the table" in conversation.reasons[-1]
    assert conversation.accepted(revision(conversation, CorrectionKind.DELETE))


def test_a_correction_that_fails_is_refused_and_the_question_stays():
    conversation = shown(0)
    event = revision(conversation, CorrectionKind.JOIN, 1)
    waiting = transition(conversation.dialogue, event).dialogue
    failed = events.RequestDone(Signal.REQUEST_DONE, conversation.tick(), "", waiting.token, False, "cannot be joined")
    outcome = transition(waiting, failed)
    assert outcome.reply is not None and not outcome.reply.accepted and outcome.reply.reason == "cannot be joined"
    assert outcome.effects == ()
    assert outcome.dialogue == replace(conversation.dialogue, token=waiting.token)


def test_the_first_task_is_not_asked_about_while_another_is_recorded():
    """Recorded anew, the steps in doubt are those of the new task only."""
    conversation = shown(0)
    assert conversation.do(Signal.BACK) and conversation.do(Signal.START)
    asked = len([p for p in conversation.prompts if p.kind is PromptKind.WHICH_WAS_MEANT])
    outcome = conversation.feed(Event(Signal.STOP, conversation.tick(), "wizard/demonstration"))
    assert outcome.dialogue.phase is Phase.TUCK_AND_CLEAR
    assert len([p for p in conversation.prompts if p.kind is PromptKind.WHICH_WAS_MEANT]) == asked


def test_a_demonstration_stopped_too_early_and_shown_again_is_asked_about_again():
    """Also where the same step of the same objects is in doubt, and was left so before: it is another demonstration."""
    conversation = shown(0)
    assert conversation.do(Signal.SKIP) and conversation.do(Signal.BACK)
    assert conversation.dialogue.phase is Phase.DEMONSTRATE and conversation.dialogue.question is None
    asked = [p for p in conversation.prompts if p.kind is PromptKind.WHICH_WAS_MEANT]
    assert conversation.do(Signal.START) and conversation.do(Signal.STOP)
    assert conversation.dialogue.question is None  # the task of the first one is forgotten until the other's comes
    show(conversation, colored(doubtful_task(4, 0)))
    assert conversation.dialogue.question is not None
    assert [p for p in conversation.prompts if p.kind is PromptKind.WHICH_WAS_MEANT] == [*asked, *asked]
    assert conversation.answer("s1")


def test_over_real_messages_the_answer_reaches_the_demonstration_and_the_task_is_without_doubt(session):
    session.task = doubtful_task(3, 0)
    assert session.send("command", command=m.WizardCommand.NEXT_PHASE).accepted
    assert session.send("demonstration", command=m.WizardDemonstration.START).accepted
    assert session.send("demonstration", command=m.WizardDemonstration.STOP).accepted
    session.until(lambda: session.received["prompt"][-1].kind == m.Prompt.WHICH_WAS_MEANT)
    assert list(session.received["prompt"][-1].source_ids) == ["s1", "s2"]
    assert not session.send("pointed", object_id="s3").accepted
    assert session.send("pointed", object_id="s2").accepted
    assert session.task.steps[0].primary_object == "s2" and session.task.steps[0].doubt == 0.0
    session.until(lambda: session.received["prompt"][-1].kind == m.Prompt.INFORM)
    reply = session.send("revision", change=m.WizardRevision.DELETE, step=7)
    assert not reply.accepted and "there is no step 8" in reply.reason
    assert not session.send("revision", change=99).accepted
    assert session.send("revision", change=m.WizardRevision.DELETE, step=0).accepted
    session.until(lambda: len(session.node._dialogue.steps) == 2)
