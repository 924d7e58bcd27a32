"""The assist loop: wait for what the mapping infers, then ask about a step or go on alone (paper sec. 4.2, 7)."""

from __future__ import annotations

import math
from dataclasses import replace

from mbd_model.assists import Assist, AssistKind
from mbd_model.boxes import nearest
from mbd_model.objects import Scene
from mbd_model.session import Phase
from mbd_model.task import StepKind, TaskStep
from mbd_model.times import to_seconds

from mbd_interaction.dialogue import (
    Dialogue,
    Effect,
    EventRefusedError,
    Outcome,
    PublishPrompt,
    QuestionOrder,
    enter,
    inform,
    with_assists,
)
from mbd_interaction.events import Answered, EstimateReceived, Event, Overwritten, Signal, TargetReceived, TaskReceived
from mbd_interaction.prompts import PHASE_TEXT, question, remaining_steps, statement

KIND_OF_STEP = {StepKind.PICK: AssistKind.HANDED, StepKind.PLACE: AssistKind.POINTED}
# [ns] by which the clocks of two nodes may differ (a simulated clock ticks); people answer more slowly than this.
CLOCK_TOLERANCE = 250_000_000
SIGNAL_OF_STEP = {StepKind.PICK: Signal.HANDED, StepKind.PLACE: Signal.POINTED}


def begin_assists(dialogue: Dialogue, at: int, detail: str = "") -> Outcome:
    """Enter ASSIST without assists."""
    fresh = replace(dialogue, skipped=frozenset())
    fresh, published = with_assists(enter(fresh, Phase.ASSIST, detail or PHASE_TEXT[Phase.ASSIST]), (), at)
    return consider(fresh, at, (published, inform(fresh.detail)))


def consider(dialogue: Dialogue, at: int, effects: tuple[Effect, ...] = ()) -> Outcome:
    """What to do in ASSIST now: wait for the estimate of the present assists, ask about a step, or go on alone."""
    if dialogue.paused:
        return Outcome(dialogue, effects)
    belief = dialogue.belief
    if dialogue.task is None or dialogue.target is None or belief is None:
        missing = (
            "the task" if dialogue.task is None else "the target scene" if dialogue.target is None else "the mapping"
        )
        return Outcome(replace(dialogue, step_index=-1, detail=f"waiting for {missing}"), effects)
    step = _next_step(dialogue, belief)
    if step is None or (belief.confident and dialogue.insist < 0):
        return execute(dialogue, effects)
    prompt = question(step)
    asked = replace(dialogue, step_index=step.index, detail=prompt.text, asked_at=at, insist=-1)
    return Outcome(asked, (*effects, PublishPrompt(prompt)))


def execute(dialogue: Dialogue, effects: tuple[Effect, ...] = ()) -> Outcome:
    """Enter EXECUTE and state the rest of the task as predicted."""
    text, steps = statement(dialogue), remaining_steps(dialogue)
    executing = replace(enter(dialogue, Phase.EXECUTE, text), step_index=steps[0].index if steps else -1)
    return Outcome(executing, (*effects, inform(text)))


def _next_step(dialogue: Dialogue, belief: EstimateReceived) -> TaskStep | None:
    steps = dialogue.open_steps
    for step in steps:
        if step.index == dialogue.insist:
            return step
    if dialogue.config.question_order is QuestionOrder.INFORMATIVE and belief.estimate:
        for step in steps:
            if step.primary_object == belief.estimate.next_question:
                return step
    return steps[0] if steps else None


def answered(dialogue: Dialogue, event: Event) -> Outcome:
    """HANDED or POINTED: an assist for the step asked about."""
    if not isinstance(event, Answered):
        raise EventRefusedError(f"'{event.signal}' came without an object or a place")
    step, target_id = _answered_step(dialogue, event), meant_object(dialogue, event)
    last = dialogue.assists[-1] if dialogue.assists else None
    if last and last.target_id == target_id:
        raise EventRefusedError(
            f"repeated: {target_id} was just taken for {last.source_id} and counts once; undo if that was wrong"
        )
    assist = Assist(step.primary_object, target_id, step.index, KIND_OF_STEP[step.kind], to_seconds(event.at))
    assisted, published = with_assists(replace(dialogue, insist=-1), (*dialogue.assists, assist), event.at)
    also = [a.source_id for a in dialogue.assists if a.target_id == target_id]
    note = f"; note: {target_id} was given for {also[-1]} too" if also else ""
    outcome = consider(assisted, event.at, (published,))
    return replace(outcome, confirmation=f"{step.primary_object} corresponds to {target_id}{note}")


def _answered_step(dialogue: Dialogue, event: Answered) -> TaskStep:
    if dialogue.step_index < 0:
        raise EventRefusedError(
            f"nothing is asked just now ({dialogue.detail}): answer the next question when it comes"
        )
    step = dialogue.steps[dialogue.step_index]
    if event.at < dialogue.asked_at - CLOCK_TOLERANCE:
        raise EventRefusedError("late: this answer is older than the question asked now; answer that one")
    if event.signal is not SIGNAL_OF_STEP[step.kind]:
        raise EventRefusedError(
            f"step {step.index + 1} is a {step.kind.name}: answer it on wizard/{SIGNAL_OF_STEP[step.kind]}, "
            f"not on wizard/{event.signal}"
        )
    return step


def meant_object(dialogue: Dialogue, event: Answered) -> str:
    """Id of the target object named or pointed at; raises EventRefusedError when there is none."""
    target = _target(dialogue)
    if event.object_id:
        return _known(target, event.object_id)
    if event.signal is not Signal.POINTED:
        raise EventRefusedError(f"object_id is empty: name the target object, one of {sorted(target.ids)}")
    if not all(math.isfinite(v) for v in event.place):
        raise EventRefusedError(f"the place {event.place} is not three finite numbers [m]")
    in_hand = {a.target_id for a in dialogue.assists if a.kind is AssistKind.HANDED}
    order = nearest(event.place, tuple(o for o in target.objects if o.object_id not in in_hand))
    if not order or order[0][0] > dialogue.config.point_reach:
        far = (
            f"the nearest, '{order[0][1].object_id}', is {order[0][0]:.2f} m away" if order else "all were handed over"
        )
        raise EventRefusedError(
            f"no target object is within {dialogue.config.point_reach} m of the place: {far}; name the object"
        )
    return order[0][1].object_id


def _target(dialogue: Dialogue) -> Scene:
    if dialogue.target is None:
        raise EventRefusedError("there is no target scene yet: observe the target objects first")
    return dialogue.target


def _known(target: Scene, object_id: str) -> str:
    if object_id not in target.ids:
        raise EventRefusedError(f"unknown object '{object_id}': the target scene has {sorted(target.ids)}")
    return object_id


def overwrite(dialogue: Dialogue, event: Event) -> Outcome:
    """OVERWRITE, "I meant this one": replaces the assist of a step; during execution, also gives a missing one."""
    index, object_id = (event.step_index, event.object_id) if isinstance(event, Overwritten) else (-1, "")
    if not 0 <= index < len(dialogue.steps):
        raise EventRefusedError(
            f"there is no step with index {index}: the task has {len(dialogue.steps)}, counted from 0"
        )
    step, target_id = dialogue.steps[index], _known(_target(dialogue), object_id)
    old = next((a for a in dialogue.assists if a.source_id == step.primary_object), None)
    if old is None and dialogue.phase is not Phase.EXECUTE:
        raise EventRefusedError(f"step {index + 1} has no assist to overwrite yet: answer it when it is asked")
    if old and old.target_id == target_id:
        raise EventRefusedError(f"repeated: {step.primary_object} corresponds to {target_id} already")
    new = Assist(step.primary_object, target_id, index, KIND_OF_STEP[step.kind], to_seconds(event.at))
    if old:
        new = replace(new, step_index=old.step_index, kind=old.kind)
    assists = tuple(new if a is old else a for a in dialogue.assists) + (() if old else (new,))
    waiting = enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST])
    assisted, published = with_assists(waiting, assists, event.at)
    outcome = consider(assisted, event.at, (published,))
    return replace(outcome, confirmation=f"{step.primary_object} now corresponds to {target_id}")


def undo(dialogue: Dialogue, event: Event) -> Outcome:
    """UNDO: withdraw the last assist and ask about its step again, whatever the confidence."""
    if not dialogue.assists:
        raise EventRefusedError("there is no assist to withdraw")
    last = dialogue.assists[-1]
    back = replace(enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]), insist=last.step_index)
    assisted, published = with_assists(back, dialogue.assists[:-1], event.at)
    outcome = consider(assisted, event.at, (published,))
    return replace(outcome, confirmation=f"withdrew that {last.source_id} corresponds to {last.target_id}")


def skip(dialogue: Dialogue, event: Event) -> Outcome:
    """SKIP: leave the step asked about without an assist."""
    if dialogue.step_index < 0:
        raise EventRefusedError(f"nothing is asked just now ({dialogue.detail}): there is no step to skip")
    skipped = replace(dialogue, skipped=dialogue.skipped | {dialogue.step_index}, step_index=-1)
    return replace(consider(skipped, event.at), confirmation=f"step {dialogue.step_index + 1} stays without an assist")


def estimate_received(dialogue: Dialogue, event: Event) -> Outcome:
    """ESTIMATE: remember it; in ASSIST it decides what comes next, if it came of the present inputs."""
    if not isinstance(event, EstimateReceived):
        return Outcome(dialogue)
    waited = dialogue.belief is None
    updated = replace(dialogue, last_estimate=event)
    if waited and updated.belief and dialogue.phase is Phase.ASSIST:
        return consider(updated, event.at)
    if waited and updated.belief and dialogue.phase is Phase.EXECUTE:
        return execute(updated)  # the node came back during execution: what it does is stated again
    return Outcome(updated)


def overdue(dialogue: Dialogue, event: Event) -> Outcome:
    """OVERDUE: no estimate came; report where it should come from."""
    if dialogue.belief is not None or dialogue.paused:
        return Outcome(dialogue)
    text = f"I am still {dialogue.detail}: are the mapping and demonstration nodes running?"
    return Outcome(dialogue, (inform(text),))


def task_received(dialogue: Dialogue, event: Event) -> Outcome:
    """TASK: remember it; another one during the assists starts them over."""
    if not isinstance(event, TaskReceived):
        return Outcome(dialogue)
    known = dialogue.task is not None and dialogue.task_stamp != event.stamp
    return _input_received(replace(dialogue, task=event.task, task_stamp=event.stamp), event.at, known)


def target_received(dialogue: Dialogue, event: Event) -> Outcome:
    """TARGET: remember it; another one during the assists starts them over."""
    if not isinstance(event, TargetReceived):
        return Outcome(dialogue)
    known = dialogue.target is not None and dialogue.target_stamp != event.stamp
    return _input_received(replace(dialogue, target=event.scene, target_stamp=event.stamp), event.at, known)


def _input_received(dialogue: Dialogue, at: int, changed: bool) -> Outcome:
    if dialogue.phase not in (Phase.ASSIST, Phase.EXECUTE):
        return Outcome(dialogue)
    targets = set(dialogue.target.ids) if dialogue.target else {a.target_id for a in dialogue.assists}
    sources = {s.primary_object for s in dialogue.steps} if dialogue.task else {a.source_id for a in dialogue.assists}
    fits = all(a.target_id in targets and a.source_id in sources for a in dialogue.assists)
    asks_what_is_not = dialogue.task is not None and dialogue.step_index >= len(dialogue.steps)
    if changed or not fits or asks_what_is_not:
        return begin_assists(dialogue, at, "The task or the new objects changed; I ask from the beginning.")
    if dialogue.phase is Phase.ASSIST and dialogue.step_index < 0:
        return consider(dialogue, at)
    return Outcome(dialogue)
