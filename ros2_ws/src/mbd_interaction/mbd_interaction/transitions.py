"""The dialogue as one pure function over one table of phases and events.

``transition`` never raises on an event: what cannot be taken is refused with a reason and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from mbd_model.session import Phase

from mbd_interaction.dialogue import Dialogue, EventRefusedError, Outcome
from mbd_interaction.effects import Reply
from mbd_interaction.events import INTERNAL, Event, Signal, Unreadable
from mbd_interaction.phases import (
    answers,
    assist_phase,
    execution_phase,
    operator_commands,
    setup_phases,
    step_corrections,
)

Handler = Callable[[Dialogue, Event], Outcome]


@dataclass(frozen=True)
class Rule:
    """What an event does in a phase.

    Attributes:
        handler: does it; raises EventRefusedError when it cannot now.
        leads_to: the phases it may lead to, its own included where it may stay.
    """

    handler: Handler
    leads_to: tuple[Phase, ...]


P, S = Phase, Signal
OBSERVE_SOURCE, DEMONSTRATE, TUCK, OBSERVE_TARGET = P.OBSERVE_SOURCE, P.DEMONSTRATE, P.TUCK_AND_CLEAR, P.OBSERVE_TARGET
ASSIST, EXECUTE, DONE, ABORTED = P.ASSIST, P.EXECUTE, P.DONE, P.ABORTED
RUNNING = (OBSERVE_SOURCE, DEMONSTRATE, TUCK, OBSERVE_TARGET, ASSIST, EXECUTE)

TABLE: dict[tuple[Phase, Signal], Rule] = {
    (OBSERVE_SOURCE, S.NEXT_PHASE): Rule(setup_phases.look_at_source, (OBSERVE_SOURCE,)),
    (OBSERVE_SOURCE, S.REQUEST_DONE): Rule(setup_phases.request_done, (OBSERVE_SOURCE, DEMONSTRATE)),
    (DEMONSTRATE, S.START): Rule(setup_phases.start_demonstration, (DEMONSTRATE,)),
    (DEMONSTRATE, S.STOP): Rule(setup_phases.stop_demonstration, (DEMONSTRATE,)),
    (DEMONSTRATE, S.REQUEST_DONE): Rule(setup_phases.request_done, (DEMONSTRATE, TUCK)),
    (TUCK, S.NEXT_PHASE): Rule(setup_phases.table_cleared, (OBSERVE_TARGET,)),
    (TUCK, S.HANDED): Rule(step_corrections.which_answered, (TUCK,)),
    (TUCK, S.POINTED): Rule(step_corrections.which_answered, (TUCK,)),
    (TUCK, S.SKIP): Rule(step_corrections.leave_in_doubt, (TUCK,)),
    (TUCK, S.REQUEST_DONE): Rule(setup_phases.request_done, (TUCK, DEMONSTRATE)),
    (OBSERVE_TARGET, S.NEXT_PHASE): Rule(setup_phases.look_at_target, (OBSERVE_TARGET,)),
    (OBSERVE_TARGET, S.REQUEST_DONE): Rule(setup_phases.request_done, (OBSERVE_TARGET, ASSIST)),
    (ASSIST, S.HANDED): Rule(answers.answered, (ASSIST,)),
    (ASSIST, S.POINTED): Rule(answers.answered, (ASSIST,)),
    (ASSIST, S.YES): Rule(answers.yes, (ASSIST,)),
    (ASSIST, S.NO): Rule(answers.no, (ASSIST,)),
    (ASSIST, S.OVERWRITE): Rule(answers.overwrite, (ASSIST,)),
    (ASSIST, S.UNDO): Rule(answers.undo, (ASSIST,)),
    (ASSIST, S.SKIP): Rule(answers.skip, (ASSIST, EXECUTE)),
    (ASSIST, S.ESTIMATE): Rule(assist_phase.estimate_received, (ASSIST, EXECUTE)),
    (ASSIST, S.OVERDUE): Rule(assist_phase.overdue, (ASSIST,)),
    (EXECUTE, S.NEXT_PHASE): Rule(setup_phases.finish, (DONE,)),
    (EXECUTE, S.OVERWRITE): Rule(answers.overwrite, (ASSIST,)),
    (EXECUTE, S.UNDO): Rule(answers.undo, (ASSIST,)),
    (EXECUTE, S.NO): Rule(execution_phase.not_that_one, (ASSIST,)),
    (EXECUTE, S.HANDED): Rule(execution_phase.corrected, (ASSIST, EXECUTE)),
    (EXECUTE, S.POINTED): Rule(execution_phase.corrected, (ASSIST, EXECUTE)),
    (EXECUTE, S.PROGRESS): Rule(execution_phase.progress_received, (ASSIST, EXECUTE)),
    **{
        (phase, S.PROGRESS): Rule(execution_phase.progress_remembered, (phase,))
        for phase in Phase
        if phase is not EXECUTE
    },
    **{(phase, S.REDO): Rule(operator_commands.redo, (phase,)) for phase in RUNNING if phase is not ASSIST},
    (ASSIST, S.REDO): Rule(operator_commands.redo, (ASSIST,)),
    **{(phase, S.BACK): Rule(operator_commands.back, (Phase(phase - 1),)) for phase in RUNNING[1:]},
    (DONE, S.BACK): Rule(operator_commands.back, (EXECUTE, ASSIST)),
    **{(phase, S.PAUSE): Rule(operator_commands.pause, (phase,)) for phase in RUNNING},
    **{(phase, S.RESUME): Rule(operator_commands.resume, (phase,)) for phase in RUNNING if phase is not ASSIST},
    (ASSIST, S.RESUME): Rule(operator_commands.resume, (ASSIST, EXECUTE)),
    # After the session a stop still holds the hand; an abort may be taken back.
    (DONE, S.RESUME): Rule(operator_commands.resume, (DONE,)),
    (ABORTED, S.RESUME): Rule(operator_commands.resume, (ABORTED, *RUNNING)),
    **{(phase, S.STOPPED): Rule(operator_commands.stopped, (phase,)) for phase in Phase},
    **{
        (phase, S.REVISE): Rule(step_corrections.revise, (phase,))
        for phase in (DEMONSTRATE, TUCK, OBSERVE_TARGET, ASSIST)
    },
    (ASSIST, S.REQUEST_DONE): Rule(setup_phases.request_done, (ASSIST,)),
    (ABORTED, S.REQUEST_DONE): Rule(setup_phases.ended_meanwhile, (ABORTED,)),
    **{(phase, S.ABORT): Rule(operator_commands.abort, (ABORTED,)) for phase in RUNNING},
    **{(phase, S.GRIPPER): Rule(operator_commands.gripper, (phase,)) for phase in Phase},
    **{(phase, S.NOTE): Rule(operator_commands.note, (phase,)) for phase in Phase},
    **{
        (phase, S.TASK): Rule(assist_phase.task_received, (phase,))
        for phase in Phase
        if phase not in (TUCK, ASSIST, EXECUTE)
    },
    (TUCK, S.TASK): Rule(step_corrections.task_of_demonstration, (TUCK,)),
    **{(phase, S.TASK): Rule(assist_phase.task_received, (ASSIST, EXECUTE)) for phase in (ASSIST, EXECUTE)},
    **{
        (phase, S.TARGET): Rule(assist_phase.target_received, (phase,))
        for phase in Phase
        if phase not in (ASSIST, EXECUTE)
    },
    **{(phase, S.TARGET): Rule(assist_phase.target_received, (ASSIST, EXECUTE)) for phase in (ASSIST, EXECUTE)},
    (EXECUTE, S.ESTIMATE): Rule(assist_phase.estimate_received, (EXECUTE, ASSIST)),
    **{
        (phase, S.ESTIMATE): Rule(assist_phase.estimate_received, (phase,))
        for phase in Phase
        if phase not in (ASSIST, EXECUTE)
    },
}
UNHINDERED = frozenset({S.PAUSE, S.RESUME, S.ABORT, S.GRIPPER, S.NOTE})


def transition(dialogue: Dialogue, event: Event) -> Outcome:
    """What an event makes of the dialogue.

    Returns:
        The new state, the effects to perform in order, and the reply to the wizard: None for an event no person
        sent, and for one whose reply comes with the result of the request it asks for.
    """
    try:
        outcome = _taken(dialogue, event)
    except EventRefusedError as refusal:
        return Outcome(dialogue, reply=Reply(event.topic, event.at, False, str(refusal)))
    if outcome.confirmation is not None:
        outcome = replace(outcome, reply=Reply(event.topic, event.at, True, outcome.confirmation))
    if outcome.reply and outcome.reply.accepted:
        counted = replace(outcome.dialogue, num_events=outcome.dialogue.num_events + 1)
        outcome = replace(outcome, dialogue=counted)
    return outcome


def expected(phase: Phase) -> list[str]:
    """The wizard events a phase takes; when the session is done nothing but a stop is resumed."""
    over = {S.RESUME} if phase is DONE else set()
    return [str(s) for p, s in TABLE if p is phase and s not in INTERNAL | over]


def _taken(dialogue: Dialogue, event: Event) -> Outcome:
    if isinstance(event, Unreadable):
        raise EventRefusedError(event.reason)
    rule = TABLE.get((dialogue.phase, event.signal))
    if event.signal in INTERNAL:
        return rule.handler(dialogue, event) if rule else Outcome(dialogue)
    if rule is None:
        phase = dialogue.phase.name.lower().replace("_", " ")
        raise EventRefusedError(
            f"'{event.signal}' is not for phase '{phase}': it takes {', '.join(expected(dialogue.phase))}"
        )
    if event.signal not in UNHINDERED:
        if dialogue.standing:
            raise EventRefusedError(f"the robot stands still ({dialogue.standing.reason}): make it safe, then resume")
        if dialogue.paused:
            raise EventRefusedError("the session is paused: resume it first")
        if dialogue.pending:
            raise EventRefusedError(f"still busy: I {dialogue.pending.request} just now; wait for the result")
    return rule.handler(dialogue, event)
