"""What was held beside what was planned: which session is next, where the plan was left, and whether that is recorded.

A deviation is found from the bags. What a bag itself states of it is its record: the fact ``plan.deviation``, which
``session --plan`` writes, and notes that begin with "deviation:". For what no bag can state (a session never held) a
person records the reason in ``deviations.csv`` beside the bags: session, reason, when. A planned session with a reason
there is not held any more.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.errors import MbdError
from mbd_model.session import Phase

from mbd_study.plan.schedule import PlannedSession
from mbd_study.plan.study_plan import PlanError

DEVIATIONS = "deviations.csv"
NOTED = "deviation:"  # begins a note that states one
_COLUMNS = ("session", "reason", "recorded")


@dataclass(frozen=True)
class HeldSession:
    """One session as its bag states it.

    Attributes:
        session, participant, task: facts.
        start: when it began [ns]: by the wall clock where the bag states that, else its first log time.
        phase: its last, None without one.
        condition: of the study, "" where the bag does not state it.
        deviation: why it is not as planned, "" where the bag states nothing of that.
        instead_of: the session that was next by the plan when this one was held, "" when this one was.
    """

    session: str
    participant: str
    task: str
    start: int
    phase: Phase | None
    condition: str = ""
    deviation: str = ""
    instead_of: str = ""


@dataclass(frozen=True)
class Deviation:
    """Where the plan was left; ``reason`` is what a person recorded, "" when nobody did."""

    session: str
    what: str
    reason: str


def held_sessions(folder: Path) -> tuple[tuple[HeldSession, ...], tuple[str, ...]]:
    """The sessions whose bags lie below a folder, oldest first, and what could not be read, a sentence each.

    Copies of one session (repaired, shared) count once; first tries that were recorded again do not count.

    Raises:
        PlanError: there is no such folder.
    """
    if not folder.is_dir():
        raise PlanError(f"there is no folder {folder}; give the one that holds the study's sessions")
    try:
        paths = list(bags_below([folder]))
    except MbdError:
        # Before the first session there is none, which is no mistake.
        return (), ()
    found: dict[str, HeldSession] = {}
    problems = []
    for path in paths:
        try:
            held = _held(Bag(path))
        except MbdError as error:
            problems.append(f"{path}: {error}")
            continue
        before = found.get(held.session)
        if before is None or (before.phase is not Phase.DONE and held.phase is Phase.DONE):
            found[held.session] = held
    return tuple(sorted(found.values(), key=lambda h: h.start)), tuple(problems)


def _held(bag: Bag) -> HeldSession:
    wanted = {t.name: f"/{t.name}" for t in bag.topics if t.count}
    states = {name for name, path in wanted.items() if path.endswith("/interaction/state")}
    notes = {name for name, path in wanted.items() if path.endswith("/wizard/note")}
    last, stated = None, [bag.facts.get("plan.deviation", "")]
    for found, message in bag.decoded(states | notes) if states | notes else ():
        if found.topic in states:
            last = message
        elif (note := str(message.text).strip()).lower().startswith(NOTED):
            stated.append(" ".join(note[len(NOTED) :].split()))
    return HeldSession(
        session=bag.facts.get("session") or bag.path.name,
        participant=bag.facts.get("participant", ""),
        task=bag.facts.get("task", ""),
        start=int(begun) if (begun := bag.facts.get("begun", "")).isdecimal() else bag.start,
        phase=Phase(last.phase) if last is not None and int(last.phase) in set(Phase) else None,
        condition=bag.facts.get("plan.condition", ""),
        deviation="; ".join(filter(None, stated)),
        instead_of=bag.facts.get("plan.instead_of", ""),
    )


def deviations(
    planned: Sequence[PlannedSession], held: Sequence[HeldSession], reasons: Mapping[str, str]
) -> tuple[Deviation, ...]:
    """Every place where what was held is not what was planned, in the order of the plan, then of what was not planned.

    Args:
        planned: all sessions of the plan.
        held: oldest first; what their bags state counts as recorded.
        reasons: recorded besides, by session.
    """
    by_name = {h.session: h for h in held}
    found: list[tuple[str, str]] = []
    for place, wanted in enumerate(planned):
        own = by_name.get(wanted.session)
        later = [p for p in planned[place + 1 :] if p.participant == wanted.participant]
        if own is None:
            if any(p.session in by_name for p in later):
                found.append((wanted.session, "passed over: a later session of the participant was held"))
            elif wanted.session in reasons:
                found.append((wanted.session, "not held"))
            continue
        if own.participant != wanted.participant:
            found.append((wanted.session, f"held with participant {own.participant or 'unknown'}"))
        if own.condition not in ("", wanted.condition):
            found.append((wanted.session, f"held in condition {own.condition}, planned was {wanted.condition}"))
        if own.task != wanted.task:
            found.append((wanted.session, f"held with task {own.task or 'unknown'}, planned was {wanted.task}"))
        if own.phase is not Phase.DONE:
            ended = own.phase.name.lower() if own.phase is not None else "no phase"
            found.append((wanted.session, f"ended in {ended}, not in done"))
        early = [p.session for p in later if p.session in by_name and by_name[p.session].start < own.start]
        if early:
            found.append((wanted.session, f"held after {early[0]}, which was planned later"))
    names = {p.session for p in planned}
    found += [(h.session, "not planned") for h in held if h.session not in names]
    # The bag of a session that left the plan states that: what is not as planned, or which session it was held before.
    found += [(h.session, h.deviation) for h in held if h.deviation and h.session not in {s for s, _ in found}]
    stated = {h.instead_of: f"{h.session} was held: {h.deviation}" for h in held if h.instead_of}
    stated |= {h.session: h.deviation for h in held if h.deviation}
    return tuple(Deviation(session, what, reasons.get(session) or stated.get(session, "")) for session, what in found)


def next_session(
    planned: Iterable[PlannedSession],
    held: Iterable[HeldSession],
    reasons: Mapping[str, str],
    participant: str = "",
) -> PlannedSession | None:
    """The first planned session that was neither held nor given up; None when all are.

    Args:
        planned: in order.
        held: those there are.
        reasons: recorded, by session.
        participant: only of this one; "": of any.
    """
    done = {h.session for h in held} | set(reasons)
    wanted = (p for p in planned if p.session not in done and participant in ("", p.participant))
    return next(wanted, None)


def fidelity(
    planned: Sequence[PlannedSession], held: Sequence[HeldSession], found: Sequence[Deviation]
) -> float | None:
    """Share of the sessions, held or passed over, that kept the plan or have a recorded deviation; None: of none."""
    sessions = {h.session for h in held} | {d.session for d in found}
    if not sessions:
        return None
    return 1.0 - len({d.session for d in found if not d.reason}) / len(sessions)


def read_reasons(folder: Path) -> dict[str, str]:
    """What `record_reason` wrote, by session: several reasons of one are joined by "; ".

    Raises:
        PlanError: the file is none that `record_reason` wrote.
    """
    path = folder / DEVIATIONS
    if not path.exists():
        return {}
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            if tuple(reader.fieldnames or ()) != _COLUMNS:
                raise PlanError(f"{path} has the columns {reader.fieldnames}; expected {', '.join(_COLUMNS)}")
            reasons: dict[str, str] = {}
            for row in reader:
                session, reason = row["session"], row["reason"]
                if not session or not reason:
                    raise PlanError(f"{path} has a row without session or reason; complete it, or remove it")
                reasons[session] = f"{reasons[session]}; {reason}" if session in reasons else reason
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise PlanError(f"{path} cannot be read: {error}") from error
    return reasons


def record_reason(folder: Path, session: str, reason: str, when: str) -> None:
    """Add a deviation's reason to the folder's file.

    Args:
        folder: of the study's sessions.
        session: planned, or held without a plan.
        reason: a sentence for people.
        when: date and time, ISO 8601.

    Raises:
        PlanError: the reason is empty, or the file cannot be written.
    """
    text = " ".join(reason.split())
    if not text:
        raise PlanError(f"the reason of {session} is empty; state in a sentence why the plan was left")
    # Refused before it is added to, when it is somebody else's file.
    read_reasons(folder)
    path = folder / DEVIATIONS
    new = not path.exists()
    try:
        with path.open("a", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            if new:
                writer.writerow(_COLUMNS)
            writer.writerow((session, text, when))
    except OSError as error:
        raise PlanError(f"{path} cannot be written: {error.strerror}; choose a folder you may write") from error
