"""The phases before the assists: looking at the tables and recording the demonstration, done by other nodes."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.session import Phase

from mbd_interaction.dialogue import Dialogue, EventRefusedError, Outcome, Pending, enter
from mbd_interaction.effects import Call, Reply, Request, inform
from mbd_interaction.events import Event, RequestDone
from mbd_interaction.phases.assist_phase import begin_assists
from mbd_interaction.phases.step_corrections import ask_about_doubt, revised
from mbd_interaction.prompts import PHASE_TEXT


def _call(dialogue: Dialogue, event: Event, request: Request) -> Outcome:
    """Have a request done; the event is answered by its result."""
    token = dialogue.token + 1
    pending = Pending(request, token, event.topic, event.at)
    return Outcome(replace(dialogue, pending=pending, token=token), (Call(request, token),))


def look_at_source(dialogue: Dialogue, event: Event) -> Outcome:
    """NEXT_PHASE in OBSERVE_SOURCE: the table is ready."""
    return _call(dialogue, event, Request.OBSERVE_SOURCE)


def look_at_target(dialogue: Dialogue, event: Event) -> Outcome:
    """NEXT_PHASE in OBSERVE_TARGET: the table is ready."""
    return _call(dialogue, event, Request.OBSERVE_TARGET)


def start_demonstration(dialogue: Dialogue, event: Event) -> Outcome:
    """START in DEMONSTRATE."""
    if dialogue.recording:
        raise EventRefusedError("repeated: the demonstration is being recorded already; stop it when it is over")
    return _call(dialogue, event, Request.START)


def stop_demonstration(dialogue: Dialogue, event: Event) -> Outcome:
    """STOP in DEMONSTRATE; the demonstration node knows whether one was being recorded."""
    return _call(dialogue, event, Request.STOP)


def table_cleared(dialogue: Dialogue, event: Event) -> Outcome:
    """NEXT_PHASE in TUCK_AND_CLEAR: the arm is tucked and the table cleared."""
    text = PHASE_TEXT[Phase.OBSERVE_TARGET]
    return Outcome(enter(dialogue, Phase.OBSERVE_TARGET, text), (inform(text),), confirmation="next: observe target")


def finish(dialogue: Dialogue, event: Event) -> Outcome:
    """NEXT_PHASE in EXECUTE: the rest of the task is done."""
    if not dialogue.executed:
        now = dialogue.present_progress
        doing = now.text if now else "the robot has not begun yet; is the execution node running?"
        raise EventRefusedError(
            f"the robot still executes the task ({doing}): wait until it has finished, or correct it"
        )
    text = PHASE_TEXT[Phase.DONE]
    return Outcome(enter(dialogue, Phase.DONE, text), (inform(text),), confirmation="the session is done")


def request_done(dialogue: Dialogue, event: Event) -> Outcome:
    """REQUEST_DONE: go on when it succeeded; stay when it did not, and give the wizard the reason."""
    pending = dialogue.pending
    if not isinstance(event, RequestDone) or pending is None or event.token != pending.token:
        return Outcome(dialogue)  # of a request nobody waits for any more
    free = replace(dialogue, pending=None)
    if not event.success:
        stopped = replace(free, recording=free.recording and pending.request is not Request.STOP, detail=event.message)
        refusal = Reply(pending.topic, pending.stamp, False, event.message)
        if pending.request is Request.REVISE:  # what the robot asks stays asked
            return Outcome(free, reply=refusal)
        if pending.request is Request.STOP and dialogue.recording:  # it has ended all the same, and nothing came of it
            text = f"I stopped watching, and cannot use what I saw: {event.message}. Please start again."
            return Outcome(stopped, (inform(text),), reply=refusal)
        return Outcome(stopped, (inform(f"I could not {pending.request}: {event.message}"),), reply=refusal)
    if pending.request is Request.REVISE and pending.correction is not None:
        outcome = revised(free, pending.correction, event.at)
    else:
        outcome = _succeeded(free, event, pending.request)
    text = event.message or f"done: {pending.request}"
    return replace(outcome, reply=Reply(pending.topic, pending.stamp, True, text))


def ended_meanwhile(dialogue: Dialogue, event: Event) -> Outcome:
    """REQUEST_DONE in ABORTED: whatever came of it, the event that asked for it is answered."""
    pending = dialogue.pending
    if not isinstance(event, RequestDone) or pending is None or event.token != pending.token:
        return Outcome(dialogue)
    reply = Reply(pending.topic, pending.stamp, False, f"the session was aborted before I could {pending.request}")
    return Outcome(replace(dialogue, pending=None), reply=reply)


def _succeeded(dialogue: Dialogue, event: RequestDone, request: Request) -> Outcome:
    if request is Request.OBSERVE_SOURCE:
        return _restate_phase(replace(dialogue, recording=False), Phase.DEMONSTRATE, event.message)
    if request is Request.START:
        text = "I am watching. " + PHASE_TEXT[Phase.DEMONSTRATE]
        # The task of an earlier recording is none of this one's.
        begun = replace(
            dialogue, recording=True, detail=text, task=None, task_stamp=0, left_in_doubt=frozenset(), words=()
        )
        return Outcome(begun, (inform(text),))
    if request is Request.STOP:
        clearing = _restate_phase(replace(dialogue, recording=False, words=()), Phase.TUCK_AND_CLEAR, event.message)
        return ask_about_doubt(clearing.dialogue, event.at, clearing.effects)
    if event.scene is not None:
        dialogue = replace(dialogue, target=event.scene, target_stamp=event.scene_stamp)
    return begin_assists(dialogue, event.at)


def _restate_phase(dialogue: Dialogue, phase: Phase, found: str) -> Outcome:
    text = f"{found.rstrip('. ')}. {PHASE_TEXT[phase]}" if found else PHASE_TEXT[phase]
    return Outcome(enter(dialogue, phase, text), (inform(text),))
