"""The dialogue as one pure function over one table of phases and events.

``transition`` never raises on an event: what cannot be taken is refused with a reason and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from mbd_model.session import Phase

from mbd_interaction import assist_phase as asking
from mbd_interaction import execution_phase as alone
from mbd_interaction import operator_commands as steering
from mbd_interaction import setup_phases as showing
from mbd_interaction.dialogue import Dialogue, EventRefusedError, Outcome, Reply
from mbd_interaction.events import INTERNAL, Event, Signal, Unreadable

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
ASSIST, CARRY_ON, DONE, ABORTED = P.ASSIST, P.CARRY_ON, P.DONE, P.ABORTED
RUNNING = (OBSERVE_SOURCE, DEMONSTRATE, TUCK, OBSERVE_TARGET, ASSIST, CARRY_ON)

TABLE: dict[tuple[Phase, Signal], Rule] = {
    (OBSERVE_SOURCE, S.NEXT_PHASE): Rule(showing.look_at_source, (OBSERVE_SOURCE,)),
    (OBSERVE_SOURCE, S.DEED_DONE): Rule(showing.deed_done, (OBSERVE_SOURCE, DEMONSTRATE)),
    (DEMONSTRATE, S.START): Rule(showing.start_demonstration, (DEMONSTRATE,)),
    (DEMONSTRATE, S.STOP): Rule(showing.stop_demonstration, (DEMONSTRATE,)),
    (DEMONSTRATE, S.DEED_DONE): Rule(showing.deed_done, (DEMONSTRATE, TUCK)),
    (TUCK, S.NEXT_PHASE): Rule(showing.table_cleared, (OBSERVE_TARGET,)),
    (OBSERVE_TARGET, S.NEXT_PHASE): Rule(showing.look_at_target, (OBSERVE_TARGET,)),
    (OBSERVE_TARGET, S.DEED_DONE): Rule(showing.deed_done, (OBSERVE_TARGET, ASSIST)),
    (ASSIST, S.HANDED): Rule(asking.answered, (ASSIST,)),
    (ASSIST, S.POINTED): Rule(asking.answered, (ASSIST,)),
    (ASSIST, S.OVERWRITE): Rule(asking.overwrite, (ASSIST,)),
    (ASSIST, S.UNDO): Rule(asking.undo, (ASSIST,)),
    (ASSIST, S.SKIP): Rule(asking.skip, (ASSIST, CARRY_ON)),
    (ASSIST, S.ESTIMATE): Rule(asking.estimate_heard, (ASSIST, CARRY_ON)),
    (ASSIST, S.OVERDUE): Rule(asking.overdue, (ASSIST,)),
    (CARRY_ON, S.NEXT_PHASE): Rule(showing.finish, (DONE,)),
    (CARRY_ON, S.OVERWRITE): Rule(asking.overwrite, (ASSIST,)),
    (CARRY_ON, S.UNDO): Rule(asking.undo, (ASSIST,)),
    (CARRY_ON, S.HANDED): Rule(alone.corrected, (ASSIST, CARRY_ON)),
    (CARRY_ON, S.POINTED): Rule(alone.corrected, (ASSIST, CARRY_ON)),
    (CARRY_ON, S.PROGRESS): Rule(alone.progress_heard, (ASSIST, CARRY_ON)),
    **{(phase, S.PROGRESS): Rule(alone.progress_remembered, (phase,)) for phase in Phase if phase is not CARRY_ON},
    **{(phase, S.REDO): Rule(steering.redo, (phase,)) for phase in RUNNING if phase is not ASSIST},
    (ASSIST, S.REDO): Rule(steering.redo, (ASSIST,)),
    **{(phase, S.BACK): Rule(steering.back, (Phase(phase - 1),)) for phase in (*RUNNING[1:], DONE)},
    **{(phase, S.PAUSE): Rule(steering.pause, (phase,)) for phase in RUNNING},
    **{(phase, S.RESUME): Rule(steering.resume, (phase,)) for phase in RUNNING if phase is not ASSIST},
    (ASSIST, S.RESUME): Rule(steering.resume, (ASSIST, CARRY_ON)),
    **{(phase, S.ABORT): Rule(steering.abort, (ABORTED,)) for phase in RUNNING},
    **{(phase, S.GRIPPER): Rule(steering.gripper, (phase,)) for phase in Phase},
    **{(phase, S.NOTE): Rule(steering.note, (phase,)) for phase in Phase},
    **{(phase, S.TASK): Rule(asking.task_heard, (phase,)) for phase in Phase if phase not in (ASSIST, CARRY_ON)},
    **{(phase, S.TASK): Rule(asking.task_heard, (ASSIST, CARRY_ON)) for phase in (ASSIST, CARRY_ON)},
    **{(phase, S.TARGET): Rule(asking.target_heard, (phase,)) for phase in Phase if phase not in (ASSIST, CARRY_ON)},
    **{(phase, S.TARGET): Rule(asking.target_heard, (ASSIST, CARRY_ON)) for phase in (ASSIST, CARRY_ON)},
    **{(phase, S.ESTIMATE): Rule(asking.estimate_heard, (phase,)) for phase in Phase if phase is not ASSIST},
}
UNHINDERED = frozenset({S.PAUSE, S.RESUME, S.ABORT, S.GRIPPER, S.NOTE})


def transition(dialogue: Dialogue, event: Event) -> Outcome:
    """What an event makes of the dialogue.

    Returns:
        The new state, the effects to carry out in order, and the reply to the wizard: None for an event no person
        sent, and for one whose reply comes with the result of the deed it asks for.
    """
    try:
        outcome = _taken(dialogue, event)
    except EventRefusedError as refusal:
        return Outcome(dialogue, reply=Reply(event.topic, event.at, False, str(refusal)))
    if outcome.said is not None:
        outcome = replace(outcome, reply=Reply(event.topic, event.at, True, outcome.said))
    if outcome.reply and outcome.reply.accepted:
        counted = replace(outcome.dialogue, num_events=outcome.dialogue.num_events + 1)
        outcome = replace(outcome, dialogue=counted)
    return outcome


def expected(phase: Phase) -> list[str]:
    """The wizard events a phase takes."""
    return [str(s) for p, s in TABLE if p is phase and s not in INTERNAL]


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
        if dialogue.paused:
            raise EventRefusedError("the session is paused: resume it first")
        if dialogue.pending:
            raise EventRefusedError(f"still busy: I {dialogue.pending.deed} just now; wait for the result")
    return rule.handler(dialogue, event)
