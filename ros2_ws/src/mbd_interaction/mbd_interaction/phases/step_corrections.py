"""Corrections of the demonstrated steps, and the question about a step whose primary object is in doubt.

"Did you pick the red cup or the blue cup?" is asked as soon as the demonstration is over, while the table still shows
it. The answer corrects the task; without one the session goes on, and the mapping weighs the step by its doubt.
"""

from __future__ import annotations

from dataclasses import replace

from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.session import Phase, PromptKind
from mbd_model.task import TaskStep

from mbd_interaction.dialogue import AskedQuestion, Dialogue, EventRefusedError, Outcome, Pending, enter
from mbd_interaction.effects import Call, Effect, PublishPrompt, Request, inform
from mbd_interaction.events import Answered, Event, Revised
from mbd_interaction.phases.assist_phase import task_received
from mbd_interaction.phases.lateness import refuse_late
from mbd_interaction.prompts import PHASE_TEXT, which_was_meant

BEFORE_CLEARING = (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR)


def revise(dialogue: Dialogue, event: Event) -> Outcome:
    """REVISE: have a step of the task corrected; the demonstration node's answer is the reply."""
    if not isinstance(event, Revised) or event.correction is None:
        raise EventRefusedError(f"'{event.signal}' came without a correction")
    if event.correction.kind is CorrectionKind.RERECORD and dialogue.phase not in BEFORE_CLEARING:
        raise EventRefusedError("the source objects are off the table: go back to the demonstration to record it again")
    return _call(dialogue, event, event.correction)


def _call(dialogue: Dialogue, event: Event, correction: StepCorrection) -> Outcome:
    token = dialogue.token + 1
    pending = Pending(Request.REVISE, token, event.topic, event.at, correction)
    return Outcome(replace(dialogue, pending=pending, token=token), (Call(Request.REVISE, token, correction),))


def revised(dialogue: Dialogue, correction: StepCorrection, at: int) -> Outcome:
    """The demonstration node corrected the task: it records again, or the task comes on its topic."""
    if correction.kind is not CorrectionKind.RERECORD:
        return Outcome(dialogue)
    text = "I am watching. " + PHASE_TEXT[Phase.DEMONSTRATE]
    recording = replace(enter(dialogue, Phase.DEMONSTRATE, text), recording=True, words=())
    return Outcome(recording, (inform(text),))


def task_of_demonstration(dialogue: Dialogue, event: Event) -> Outcome:
    """TASK in TUCK_AND_CLEAR: remember it, and ask about a step of it that is in doubt."""
    outcome = task_received(dialogue, event)
    return ask_about_doubt(outcome.dialogue, event.at, outcome.effects)


def doubtful_step(dialogue: Dialogue) -> TaskStep | None:
    """The first step in doubt that was not left so; None when there is none."""
    for step in dialogue.steps:
        if step.doubt >= dialogue.config.doubt_asked and step.runner_up and step.end not in dialogue.left_in_doubt:
            return step
    return None


def ask_about_doubt(dialogue: Dialogue, at: int, effects: tuple[Effect, ...] = ()) -> Outcome:
    """In TUCK_AND_CLEAR: ask about the first step in doubt, or say that nothing is asked any more."""
    step, task = doubtful_step(dialogue), dialogue.task
    if step is None or task is None:
        if dialogue.question is None:
            return Outcome(dialogue, effects)
        text = PHASE_TEXT[dialogue.phase]
        return Outcome(enter(dialogue, dialogue.phase, text), (*effects, inform(text)))
    prompt = which_was_meant(task, step)
    question = AskedQuestion(prompt.kind, source_ids=prompt.source_ids)
    asked = replace(dialogue, step_index=step.index, question=question, detail=prompt.text, asked_at=at)
    if (asked.step_index, asked.question) == (dialogue.step_index, dialogue.question):
        return Outcome(dialogue, effects)
    return Outcome(asked, (*effects, PublishPrompt(prompt)))


def _asked(dialogue: Dialogue) -> AskedQuestion:
    question = dialogue.question
    if question is None or question.kind is not PromptKind.WHICH_WAS_MEANT:
        raise EventRefusedError(f"nothing is asked just now ({dialogue.detail})")
    return question


def which_answered(dialogue: Dialogue, event: Event) -> Outcome:
    """HANDED or POINTED in TUCK_AND_CLEAR: which of the two source objects the step was about."""
    question = _asked(dialogue)
    refuse_late(dialogue, event)
    object_id = event.object_id if isinstance(event, Answered) else ""
    if object_id not in question.source_ids:
        raise EventRefusedError(
            f"'{object_id}' is neither of the two: name {' or '.join(question.source_ids)}, or skip the question"
        )
    return _call(dialogue, event, StepCorrection(CorrectionKind.CHANGE_OBJECT, dialogue.step_index, 0, object_id))


def leave_in_doubt(dialogue: Dialogue, event: Event) -> Outcome:
    """SKIP in TUCK_AND_CLEAR: the step asked about stays in doubt."""
    _asked(dialogue)
    step = dialogue.steps[dialogue.step_index]
    left = replace(dialogue, left_in_doubt=dialogue.left_in_doubt | {step.end})
    outcome = ask_about_doubt(left, event.at)
    return replace(outcome, confirmation=f"step {step.index + 1} stays in doubt ({step.doubt:.0%})")
