"""While the robot executes the task alone: its progress, its failures, and corrections by the teacher."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.assists import Denial
from mbd_model.execution_progress import Status
from mbd_model.session import Phase
from mbd_model.task import StepKind, TaskStep
from mbd_model.times import to_seconds

from mbd_interaction.dialogue import Dialogue, EventRefusedError, Outcome, enter, with_assists
from mbd_interaction.effects import inform
from mbd_interaction.events import Answered, Event, Overwritten, ProgressReceived, Signal
from mbd_interaction.phases.answers import meant_object, overwrite, undoable
from mbd_interaction.phases.assist_phase import consider
from mbd_interaction.phases.help_requests import BY_OBJECT, ask_for_help
from mbd_interaction.prompts import PHASE_TEXT

STEP_OF_ANSWER = {Signal.HANDED: StepKind.PICK, Signal.POINTED: StepKind.PLACE}


def progress_remembered(dialogue: Dialogue, event: Event) -> Outcome:
    """PROGRESS outside EXECUTE: what the robot puts back, or did before this node came back."""
    return Outcome(replace(dialogue, progress=event) if isinstance(event, ProgressReceived) else dialogue)


def progress_received(dialogue: Dialogue, event: Event) -> Outcome:
    """PROGRESS in EXECUTE: a step that failed for the last time is asked about, whatever was answered before."""
    updated = progress_remembered(dialogue, event).dialogue
    now = updated.present_progress
    if not updated.config.execute or now is None or now.status is not Status.FAILED:
        return Outcome(updated)
    if not 0 <= now.step_index < len(updated.steps):
        return Outcome(updated)
    if now.failure not in BY_OBJECT:
        return ask_for_help(updated, now, event.at)
    step = updated.steps[now.step_index]
    assist_phase = replace(
        enter(updated, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]),
        insist=step.index,
        skipped=updated.skipped - {s.index for s in updated.steps if s.primary_object == step.primary_object},
    )
    # Its assist is withdrawn, so that the answer counts again even when it names the same object.
    others = tuple(a for a in assist_phase.assists if a.source_id != step.primary_object)
    assisted, published = with_assists(assist_phase, others, event.at)
    return consider(assisted, event.at, (published, inform(f"I need help: {now.text}.")))


def corrected(dialogue: Dialogue, event: Event) -> Outcome:
    """HANDED or POINTED in EXECUTE: the object meant for the step the robot is at, as an overwritten assist."""
    if not isinstance(event, Answered):
        raise EventRefusedError(f"'{event.signal}' came without an object or a place")
    step = _step_meant(dialogue, event.signal)
    target_id = meant_object(dialogue, event)
    return overwrite(dialogue, Overwritten(Signal.OVERWRITE, event.at, event.topic, step.index, target_id))


def not_that_one(dialogue: Dialogue, event: Event) -> Outcome:
    """NO in EXECUTE, "not that one": the object in use at the step under way is none for it; the mapping infers again.

    The robot stops as soon as the phase is left, and puts back what it holds.
    """
    now, belief = dialogue.present_progress, dialogue.belief
    if now is None or not 0 <= now.step_index < len(dialogue.steps) or belief is None or belief.estimate is None:
        raise EventRefusedError("no step is being done just now: name the step meant on wizard/overwrite")
    step = dialogue.steps[now.step_index]
    source_id = step.primary_object
    target_id = belief.estimate.executed.as_dict.get(source_id)
    if target_id is None:
        raise EventRefusedError(f"nothing is used for {source_id} just now")
    denials = tuple(d for d in dialogue.denials if (d.source_id, d.target_id) != (source_id, target_id))
    kept = tuple(a for a in dialogue.assists if (a.source_id, a.target_id) != (source_id, target_id))
    assist_phase = replace(
        enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]),
        insist=step.index if len(kept) < len(dialogue.assists) else -1,
        skipped=dialogue.skipped - {s.index for s in dialogue.steps if s.primary_object == source_id},
    )
    denied = Denial(source_id, target_id, step.index, to_seconds(event.at))
    without, published = with_assists(assist_phase, kept, event.at, denials=(*denials, denied))
    outcome = undoable(dialogue, consider(without, event.at, (published,)), step.index)
    return replace(outcome, confirmation=f"{source_id} does not correspond to {target_id}")


def _step_meant(dialogue: Dialogue, signal: Signal) -> TaskStep:
    now = dialogue.present_progress
    if not dialogue.config.execute or now is None or not 0 <= now.step_index < len(dialogue.steps):
        raise EventRefusedError("no step is being done just now: name the step meant on wizard/overwrite")
    kind = STEP_OF_ANSWER[signal]
    # A pick and the place after it belong together: an object handed during the place corrects the pick before it.
    index = now.step_index
    if dialogue.steps[index].kind is not kind:
        index += 1 if kind is StepKind.PLACE else -1
    if not 0 <= index < len(dialogue.steps) or dialogue.steps[index].kind is not kind:
        raise EventRefusedError("the task has no such step: name the step meant on wizard/overwrite")
    return dialogue.steps[index]
