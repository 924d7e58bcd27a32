"""What the teacher answers: an object, a place, yes or no; and what takes an answer back."""

from __future__ import annotations

import math
from dataclasses import replace

from mbd_model.assists import Assist, AssistKind, Denial
from mbd_model.execution_progress import Verdict
from mbd_model.geometry.boxes import nearest
from mbd_model.objects import Scene
from mbd_model.session import Phase, PromptKind
from mbd_model.task import StepKind, TaskStep
from mbd_model.times import to_seconds

from mbd_interaction.dialogue import AnswerTaken, Dialogue, EventRefusedError, Outcome, enter, with_assists
from mbd_interaction.events import Answered, Event, Overwritten, Signal
from mbd_interaction.phases.assist_phase import consider
from mbd_interaction.phases.help_requests import another, asks_for_help, judged, left_out
from mbd_interaction.phases.lateness import refuse_late
from mbd_interaction.prompts import PHASE_TEXT

KIND_OF_STEP = {StepKind.PICK: AssistKind.HANDED, StepKind.PLACE: AssistKind.POINTED}
SIGNAL_OF_STEP = {StepKind.PICK: Signal.HANDED, StepKind.PLACE: Signal.POINTED}
NAMED = (PromptKind.CONFIRM_ASSIST, PromptKind.IS_THIS_IT, PromptKind.WHICH_OF_TWO)


def answered(dialogue: Dialogue, event: Event) -> Outcome:
    """HANDED or POINTED: an assist for the step asked about, or the right one in place of the one asked about."""
    if not isinstance(event, Answered):
        raise EventRefusedError(f"'{event.signal}' came without an object or a place")
    if asks_for_help(dialogue):
        return another(dialogue, event, meant_object(dialogue, event))
    step, target_id = _answered_step(dialogue, event), meant_object(dialogue, event)
    if dialogue.question and dialogue.question.kind is PromptKind.CONFIRM_ASSIST:
        if dialogue.question.target_ids == (target_id,):
            return yes(dialogue, event)
        meant = Overwritten(Signal.OVERWRITE, event.at, event.topic, step.index, target_id)
        return undoable(dialogue, _overwritten(dialogue, meant, confirmed=True), step.index)
    last = dialogue.assists[-1] if dialogue.assists else None
    if last and last.target_id == target_id:
        raise EventRefusedError(
            f"repeated: {target_id} was just taken for {last.source_id} and counts once; undo if that was wrong"
        )
    return _with_assist(dialogue, step, target_id, event.at)


def _with_assist(dialogue: Dialogue, step: TaskStep, target_id: str, at: int) -> Outcome:
    confirmed = _asked_about(dialogue, step.primary_object)
    assist = Assist(step.primary_object, target_id, step.index, KIND_OF_STEP[step.kind], to_seconds(at), confirmed)
    assisted, published = with_assists(replace(dialogue, insist=-1), (*dialogue.assists, assist), at)
    also = [a.source_id for a in dialogue.assists if a.target_id == target_id]
    note = f"; note: {target_id} was given for {also[-1]} too" if also else ""
    outcome = consider(assisted, at, (published,))
    return replace(outcome, confirmation=f"{step.primary_object} corresponds to {target_id}{note}")


def _asked_about(dialogue: Dialogue, source_id: str) -> bool:
    """Whether an assist about this object was withdrawn when it was asked about: then the next was thought over."""

    def claims(lists: tuple[tuple[Assist, ...], tuple[Denial, ...]]) -> set[str]:
        return {a.target_id for a in lists[0] if a.source_id == source_id}

    return any(claims(taken.before) - claims(taken.after) for taken in dialogue.yes_or_no)


def _answered_step(dialogue: Dialogue, event: Event) -> TaskStep:
    step = _step_asked(dialogue, event)
    # Which of the objects named is shown by handing it over as well as by pointing at it.
    names_objects = dialogue.question is not None and dialogue.question.kind in NAMED
    if not names_objects and event.signal is not SIGNAL_OF_STEP[step.kind]:
        raise EventRefusedError(
            f"step {step.index + 1} is a {step.kind.name}: answer it on wizard/{SIGNAL_OF_STEP[step.kind]}, "
            f"not on wizard/{event.signal}"
        )
    return step


def _step_asked(dialogue: Dialogue, event: Event) -> TaskStep:
    if dialogue.step_index < 0:
        raise EventRefusedError(
            f"nothing is asked just now ({dialogue.detail}): answer the next question when it comes"
        )
    step = dialogue.steps[dialogue.step_index]
    refuse_late(dialogue, event)
    return step


def yes(dialogue: Dialogue, event: Event) -> Outcome:
    """YES: the assist asked about is certain from now on; or the object asked about is an assist."""
    if asks_for_help(dialogue):
        return judged(dialogue, event, Verdict.YES)
    step, question = _step_asked(dialogue, event), dialogue.question
    if question and question.kind is PromptKind.CONFIRM_ASSIST:
        return _confirmed(dialogue, step, question.target_ids[0], event.at)
    if question and question.kind is PromptKind.IS_THIS_IT:
        return undoable(dialogue, _with_assist(dialogue, step, question.target_ids[0], event.at), step.index)
    signal = SIGNAL_OF_STEP[step.kind]
    if question and question.kind is PromptKind.WHICH_OF_TWO:
        first, second = question.target_ids
        raise EventRefusedError(f"which of the two? answer {first} or {second} on wizard/{signal}, or no for neither")
    raise _not_yes_or_no(step)


def _confirmed(dialogue: Dialogue, step: TaskStep, target_id: str, at: int) -> Outcome:
    meant = (step.primary_object, target_id)
    assists = tuple(replace(a, confirmed=True) if (a.source_id, a.target_id) == meant else a for a in dialogue.assists)
    certain, published = with_assists(_nothing_asked(dialogue), assists, at)
    outcome = undoable(dialogue, consider(certain, at, (published,)), step.index)
    return replace(outcome, confirmation=f"confirmed: {step.primary_object} corresponds to {target_id}")


def no(dialogue: Dialogue, event: Event) -> Outcome:
    """NO: the assist asked about is withdrawn and its step asked again; or what was named is none of its objects."""
    if asks_for_help(dialogue):
        return judged(dialogue, event, Verdict.NO)
    step, question = _step_asked(dialogue, event), dialogue.question
    if question is None or question.kind not in NAMED:
        raise _not_yes_or_no(step)
    source_id, targets = step.primary_object, question.target_ids
    denied = tuple(Denial(source_id, target, step.index, to_seconds(event.at)) for target in targets)
    earlier = tuple(d for d in dialogue.denials if not (d.source_id == source_id and d.target_id in targets))
    kept = tuple(a for a in dialogue.assists if not (a.source_id == source_id and a.target_id in targets))
    again = step.index if len(kept) < len(dialogue.assists) else -1
    free = replace(_nothing_asked(dialogue), insist=again, skipped=dialogue.skipped - {again})
    without, published = with_assists(free, kept, event.at, denials=(*earlier, *denied))
    outcome = undoable(dialogue, consider(without, event.at, (published,)), step.index)
    return replace(outcome, confirmation=f"{source_id} does not correspond to {' or '.join(targets)}")


def _not_yes_or_no(step: TaskStep) -> EventRefusedError:
    return EventRefusedError(
        f"step {step.index + 1} is a {step.kind.name}: answer it on wizard/{SIGNAL_OF_STEP[step.kind]}, "
        "not by yes or no; skip it if there is no answer"
    )


def _nothing_asked(dialogue: Dialogue) -> Dialogue:
    return replace(dialogue, step_index=-1, question=None, insist=-1)


def undoable(before: Dialogue, outcome: Outcome, step_index: int) -> Outcome:
    """The outcome of an answer to a question that named objects, remembered so that it can be taken back."""
    after = outcome.dialogue
    taken = AnswerTaken((before.assists, before.denials), (after.assists, after.denials), step_index)
    return replace(outcome, dialogue=replace(after, yes_or_no=(*after.yes_or_no, taken)))


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
    return _overwritten(dialogue, event)


def _overwritten(dialogue: Dialogue, event: Event, *, confirmed: bool = False) -> Outcome:
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
    new = Assist(step.primary_object, target_id, index, KIND_OF_STEP[step.kind], to_seconds(event.at), confirmed)
    if old:
        new = replace(new, step_index=old.step_index, kind=old.kind)
    assists = tuple(new if a is old else a for a in dialogue.assists) + (() if old else (new,))
    waiting = enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST])
    assisted, published = with_assists(waiting, assists, event.at)
    outcome = consider(assisted, event.at, (published,))
    return replace(outcome, confirmation=f"{step.primary_object} now corresponds to {target_id}")


def undo(dialogue: Dialogue, event: Event) -> Outcome:
    """UNDO: take back the last yes or no, or withdraw the last assist, and ask about its step again."""
    now = (dialogue.assists, dialogue.denials)
    last_named = next((t for t in reversed(dialogue.yes_or_no) if t.after == now), None)
    if last_named is not None:
        return _taken_back(dialogue, last_named, event.at)
    last = dialogue.assists[-1] if dialogue.assists else None
    denied = dialogue.denials[-1] if dialogue.denials else None
    if denied is not None and (last is None or denied.stamp > last.stamp):
        # Of a no before this node came back, only what it denied is known; both objects of one no have its stamp.
        rest = tuple(d for d in dialogue.denials if d.stamp != denied.stamp)
        return _taken_back(dialogue, AnswerTaken((dialogue.assists, rest), now, denied.step_index), event.at)
    if last is None:
        raise EventRefusedError("there is no assist to withdraw")
    back = replace(enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]), insist=last.step_index)
    assisted, published = with_assists(back, dialogue.assists[:-1], event.at)
    outcome = consider(assisted, event.at, (published,))
    return replace(outcome, confirmation=f"withdrew that {last.source_id} corresponds to {last.target_id}")


def _taken_back(dialogue: Dialogue, taken: AnswerTaken, at: int) -> Outcome:
    assists, denials = taken.before
    step = dialogue.steps[taken.step_index] if taken.step_index < len(dialogue.steps) else None
    asked_openly = step is not None and all(a.source_id != step.primary_object for a in assists)
    back = replace(
        enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]),
        insist=taken.step_index if asked_openly else -1,
        yes_or_no=tuple(t for t in dialogue.yes_or_no if t is not taken),
    )
    restored, published = with_assists(back, assists, at, denials=denials)
    outcome = consider(restored, at, (published,))
    return replace(outcome, confirmation=f"took back the answer about step {taken.step_index + 1}")


def skip(dialogue: Dialogue, event: Event) -> Outcome:
    """SKIP: leave the step asked about without an assist; or the assist asked about as it was given."""
    if dialogue.step_index < 0:
        raise EventRefusedError(f"nothing is asked just now ({dialogue.detail}): there is no step to skip")
    if asks_for_help(dialogue):
        return left_out(dialogue, event)
    step, question = dialogue.steps[dialogue.step_index], dialogue.question
    if question and question.kind is PromptKind.CONFIRM_ASSIST:
        meant = (step.primary_object, question.target_ids[0])
        left = replace(_nothing_asked(dialogue), kept_unconfirmed=dialogue.kept_unconfirmed | {meant})
        return replace(
            consider(left, event.at), confirmation=f"{meant[0]} corresponds to {meant[1]} as given, unconfirmed"
        )
    skipped = replace(_nothing_asked(dialogue), skipped=dialogue.skipped | {step.index})
    return replace(consider(skipped, event.at), confirmation=f"step {step.index + 1} stays without an assist")
