"""What a session came to, in names that do not depend on what perception calls an object; and whether that is right."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.session.command_line import open_session
from mbd_bag.session.recorded_session import RecordedReply
from mbd_model.errors import MbdError
from mbd_model.session import Phase
from mbd_study.recompute.session_check import check_bag
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.tables.correctness import answers_of


@dataclass(frozen=True)
class SessionFindings:
    """What a session found out, as its bag holds it; objects by their true names.

    Attributes:
        steps: kind and object of each demonstrated step.
        assists: how many were in force at last.
        mapping: the last estimate's, of the objects that the task uses.
    """

    steps: tuple[tuple[str, str], ...]
    assists: int
    mapping: tuple[tuple[str, str], ...]


def findings_of(bag: Path) -> SessionFindings:
    """Read a session's findings; raises MbdError (BagError) when the bag cannot be read or lacks them."""
    _, session = open_session(bag)
    answers = answers_of(session)
    if answers is None or not session.estimates:
        raise MbdError(f"{bag} holds no task, target scene or estimate: the session did not get that far")
    task, estimate = session.tasks[-1].value, session.estimates[-1][0].value
    pairs = estimate.executed.as_dict
    named = {
        answers.source_names.get(s, "?"): answers.target_names.get(pairs.get(s, ""), "?") for s in task.used_objects
    }
    return SessionFindings(
        tuple((s.kind.name.lower(), answers.source_names.get(s.primary_object, "?")) for s in task.steps),
        estimate.num_assists,
        tuple(sorted(named.items())),
    )


def faults_of_result(
    bag: Path, phase: Phase | None, expected: SessionFindings | None, replies: list[RecordedReply]
) -> tuple[str, ...]:
    """What is wrong with a session that is over, a sentence each; () when it is as if nothing had happened.

    Args:
        bag: of the session.
        phase: in which it ended.
        expected: what a session of the same seed without a fault found.
        replies: to wizard events, as somebody else received them; each belongs into the bag.
    """
    wrong = []
    if phase is not Phase.DONE:
        wrong.append(f"it ended in {phase.name if phase else 'no phase'}")
    try:
        found = findings_of(bag)
        _, session = open_session(bag)
        checked = check_bag(bag, RecomputeFrom.ASSISTS)
    except MbdError as error:
        return (*wrong, str(error))
    if expected is not None and found != expected:
        wrong.append(f"it found {found} where an undisturbed session found {expected}")
    if not checked.agrees:
        wrong.append(f"computed again from its bag: {checked.failure or '; '.join(checked.lines[:3])}")
    lost = Counter(replies) - Counter(r.value for r in session.replies)
    if lost:
        wrong.append(f"{sum(lost.values())} of {len(replies)} replies to the wizard are not in the bag")
    return tuple(wrong)
