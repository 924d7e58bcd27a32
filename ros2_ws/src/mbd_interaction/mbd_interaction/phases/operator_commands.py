"""What the wizard can do at any time: pause, resume, abort, back, redo, note, gripper; and a stop of the robot."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.session import GripperWord, Phase
from mbd_model.times import to_seconds

from mbd_interaction.dialogue import Dialogue, EventRefusedError, Outcome, StandingStill, enter, with_assists
from mbd_interaction.effects import Call, Effect, ReleaseStop, Request, inform
from mbd_interaction.events import Event, Gripped, Stopped
from mbd_interaction.phases.assist_phase import begin_assists, consider, execute, go_on
from mbd_interaction.prompts import PHASE_TEXT


def _discarded(dialogue: Dialogue) -> tuple[Effect, ...]:
    """A recording that runs is thrown away; nobody waits for that."""
    return (Call(Request.DISCARD, None),) if dialogue.recording else ()


def _again(dialogue: Dialogue, phase: Phase, effects: tuple[Effect, ...] = ()) -> Outcome:
    """The beginning of a phase."""
    text = PHASE_TEXT[phase]
    begun = replace(enter(dialogue, phase, text), recording=False)
    return Outcome(begun, (*effects, inform(text)), confirmation=f"now: {phase.name.lower().replace('_', ' ')}")


def pause(dialogue: Dialogue, event: Event) -> Outcome:
    """PAUSE: nothing but resume, abort, notes and the gripper until resumed."""
    if dialogue.paused:
        raise EventRefusedError("repeated: the session is paused already; resume it")
    return Outcome(replace(dialogue, paused=True), confirmation="paused")


def stopped(dialogue: Dialogue, event: Event) -> Outcome:
    """STOPPED: as paused, and the hand stays as it is too."""
    why = event.reason if isinstance(event, Stopped) and event.reason else "no reason is given"
    running = dialogue.phase not in (Phase.DONE, Phase.ABORTED)
    text = f"I stopped: {why}. Nothing moves until you make it safe and let me go on."
    return Outcome(replace(dialogue, standing=StandingStill(why), paused=dialogue.paused or running), (inform(text),))


def resume(dialogue: Dialogue, event: Event) -> Outcome:
    """RESUME, after a pause, a stop, or an abort."""
    if dialogue.phase is Phase.ABORTED and dialogue.standing is None:
        return _abort_taken_back(dialogue, event)
    if not dialogue.paused and dialogue.standing is None:
        raise EventRefusedError("the session is not paused")
    effects: tuple[Effect, ...] = (ReleaseStop(), inform("I go on.")) if dialogue.standing else ()
    resumed = replace(dialogue, paused=False, standing=None)
    if dialogue.phase is Phase.ASSIST:
        return replace(consider(resumed, event.at, effects), confirmation="resumed")
    return Outcome(resumed, effects, confirmation="resumed")


def _abort_taken_back(dialogue: Dialogue, event: Event) -> Outcome:
    """The phase that was aborted, from its beginning; asking, with the answers there were."""
    phase = dialogue.aborted_from
    if phase is None:
        raise EventRefusedError("which phase was aborted is not known any more: start the session again")
    if dialogue.pending:
        raise EventRefusedError(f"still busy: I {dialogue.pending.request} just now; wait for the result")
    back_in = replace(enter(dialogue, phase, PHASE_TEXT[phase]), aborted_from=None)
    words = f"going on: {phase.name.lower().replace('_', ' ')}"
    if phase is Phase.ASSIST:
        return replace(consider(back_in, event.at), confirmation=words)
    if phase is Phase.EXECUTE:
        return replace(execute(back_in), confirmation=words)
    return replace(_again(back_in, phase), confirmation=words)


def abort(dialogue: Dialogue, event: Event) -> Outcome:
    """ABORT: the session ends here; what it recorded stays. A request under way still answers its event.

    RESUME takes it back, to the beginning of the phase.
    """
    text = PHASE_TEXT[Phase.ABORTED]
    aborted = replace(enter(dialogue, Phase.ABORTED, text), aborted_from=dialogue.phase)
    ended = replace(aborted, paused=False, recording=False)
    return Outcome(ended, (*_discarded(dialogue), inform(text)), confirmation="aborted")


def redo(dialogue: Dialogue, event: Event) -> Outcome:
    """REDO: the present phase from its beginning."""
    if dialogue.phase is Phase.ASSIST:
        return replace(begin_assists(dialogue, event.at), confirmation="asking from the beginning")
    if dialogue.phase is Phase.EXECUTE:
        return replace(execute(dialogue), confirmation="stated again")
    return _again(dialogue, dialogue.phase, _discarded(dialogue))


def back(dialogue: Dialogue, event: Event) -> Outcome:
    """BACK: the phase before. ASSIST leaves with its assists withdrawn; from EXECUTE it asks on, however confident.

    From DONE it leads to EXECUTE, unless an assist has to be asked about first.
    """
    before = Phase(dialogue.phase - 1)
    if dialogue.phase is Phase.DONE:
        outcome = go_on(enter(dialogue, Phase.EXECUTE, PHASE_TEXT[Phase.EXECUTE]), event.at)
        return replace(outcome, confirmation=f"now: {outcome.dialogue.phase.name.lower()}")
    if dialogue.phase is Phase.EXECUTE:
        if not dialogue.open_steps:
            raise EventRefusedError("every step has its answer: undo or overwrite one instead")
        assist_phase = replace(
            enter(dialogue, Phase.ASSIST, PHASE_TEXT[Phase.ASSIST]), insist=dialogue.open_steps[0].index
        )
        return replace(consider(assist_phase, event.at), confirmation="now: assist")
    if dialogue.phase is Phase.ASSIST:
        withdrawn, published = with_assists(
            replace(dialogue, skipped=frozenset(), yes_or_no=()), (), event.at, denials=()
        )
        return _again(withdrawn, before, (published,))
    return _again(dialogue, before, _discarded(dialogue))


def note(dialogue: Dialogue, event: Event) -> Outcome:
    """NOTE: kept in the session's bag."""
    return Outcome(dialogue, confirmation="noted")


def gripper(dialogue: Dialogue, event: Event) -> Outcome:
    """GRIPPER: for the hand and, while a demonstration is recorded, one of its events; the dialogue stays."""
    if dialogue.standing:
        raise EventRefusedError(
            f"the robot stands still ({dialogue.standing.reason}), its hand too: make it safe, then resume"
        )
    close = isinstance(event, Gripped) and event.close
    verb = "close" if close else "open"
    use = "an event of the demonstration" if dialogue.recording else "for the hand only; no demonstration is recorded"
    if dialogue.recording:
        dialogue = replace(dialogue, words=(*dialogue.words, GripperWord(to_seconds(event.at), close)))
    return Outcome(dialogue, confirmation=f"{verb}: {use}")
