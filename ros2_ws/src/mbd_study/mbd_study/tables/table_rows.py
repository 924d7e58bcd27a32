"""A session as rows of plain tables: sessions, steps, assists, estimates, correspondences, events, markers, forms.

Times are seconds from the bag's start where a field does not state otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.session.session_facts import fingerprint
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.superseded import is_superseded
from mbd_model.estimate import NO_MAPPING, Mapping
from mbd_model.times import to_seconds

from mbd_study.recompute.reevaluation import input_of
from mbd_study.tables.correctness import Answers, answers_of
from mbd_study.tables.correspondences import CorrespondenceRow, correspondence_rows
from mbd_study.tables.events import EventRow, event_rows
from mbd_study.tables.forms import FormRow, ScoreRow, form_rows
from mbd_study.tables.markers import MarkerRow, marker_rows
from mbd_study.tables.steps import StepRow, step_rows


@dataclass(frozen=True)
class SessionRow:
    """One session; ``correct`` is of its last estimate, None when nobody knows."""

    session: str
    bag: str
    participant: str
    task: str
    condition: str
    position: str
    deviation: str
    seed: str
    fingerprint: str
    start_unix_s: float
    duration_s: float
    last_phase: str
    steps: int
    assists: int
    estimates: int
    wizard_events: int
    refused_events: int
    notes: int
    strategy: str
    confidence: float | None
    confident: bool | None
    correct: bool | None
    superseded: bool
    problems: str


@dataclass(frozen=True)
class GivenAssistRow:
    """One assist of one list of assists; ``revision`` counts the lists, so that withdrawn ones are seen."""

    session: str
    revision: int
    assist: int
    step: int
    source: str
    target: str
    kind: str
    given_s: float
    right: bool | None
    confirmed: bool


@dataclass(frozen=True)
class EstimateRow:
    """One estimate: the prediction, and both its readings (empty in bags of versions that named none).

    ``best_guess`` takes assists as fallible, ``obeying`` holds each of them; ``correct_...``: of that reading.
    """

    session: str
    estimate: int
    published_s: float
    assists: int
    strategy: str
    mapping: str
    confidence: float
    threshold: float
    confident: bool
    ties: int
    winning: str
    runner_up: str
    correct: bool | None
    best_guess: str
    best_guess_probability: float
    correct_best_guess: bool | None
    obeying: str
    obeying_probability: float
    correct_obeying: bool | None
    doubted: str
    doubt: float
    question_kind: str


@dataclass(frozen=True)
class SessionTables:
    """The rows of one session."""

    sessions: tuple[SessionRow, ...]
    steps: tuple[StepRow, ...]
    assists: tuple[GivenAssistRow, ...]
    estimates: tuple[EstimateRow, ...]
    correspondences: tuple[CorrespondenceRow, ...]
    events: tuple[EventRow, ...]
    markers: tuple[MarkerRow, ...]
    forms: tuple[FormRow, ...]
    scores: tuple[ScoreRow, ...]


def session_tables(bag: Bag, session: RecordedSession) -> SessionTables:
    """All rows of a session; its bag gives the times."""
    start = to_seconds(bag.start)
    answers = answers_of(session)
    estimates = []
    for number, (recorded, inputs) in enumerate(session.estimates):
        value = recorded.value
        task = input_of(session.tasks, inputs.task_stamp, recorded.log_time)
        used = task.used_objects if task is not None else None
        estimates.append(
            EstimateRow(
                session=session.name,
                estimate=number,
                published_s=to_seconds(recorded.log_time) - start,
                assists=value.num_assists,
                strategy=value.strategy,
                mapping=pairs_text(value.mapping),
                confidence=value.confidence,
                threshold=inputs.threshold,
                confident=inputs.confident,
                ties=value.ties,
                winning="+".join(value.winning),
                runner_up="+".join(value.runner_up),
                correct=None if answers is None or used is None else answers.correct(value, used),
                best_guess=pairs_text(value.best_guess),
                best_guess_probability=value.best_guess.score,
                correct_best_guess=_correct(answers, value.best_guess, used),
                obeying=pairs_text(value.obeying),
                obeying_probability=value.obeying.score,
                correct_obeying=_correct(answers, value.obeying, used),
                doubted=f"{value.doubted.source_id}>{value.doubted.target_id}" if value.doubted else "",
                doubt=value.doubt,
                question_kind=str(value.question_kind),
            )
        )
    assists = [
        GivenAssistRow(
            session=session.name,
            revision=revision,
            assist=number,
            step=given.step_index,
            source=given.source_id,
            target=given.target_id,
            kind=given.kind.name.lower(),
            given_s=to_seconds(recorded.log_time) - start,
            right=None if answers is None else answers.is_right(given.source_id, given.target_id),
            confirmed=given.confirmed,
        )
        for revision, recorded in enumerate(session.assists)
        for number, given in enumerate(recorded.value)
    ]
    events = event_rows(bag, session.name)
    forms, scores = form_rows(bag, session.name)
    last = estimates[-1] if estimates else None
    row = SessionRow(
        session=session.name,
        bag=bag.path.name,
        participant=session.facts.get("participant", ""),
        task=session.facts.get("task", ""),
        condition=session.facts.get("plan.condition", ""),
        position=session.facts.get("plan.position", ""),
        deviation=session.facts.get("plan.deviation", ""),
        seed=session.facts.get("seed", ""),
        fingerprint=session.facts.get("fingerprint") or fingerprint(session.facts),
        start_unix_s=start,
        duration_s=to_seconds(bag.end - bag.start),
        last_phase=session.states[-1].value.phase.name.lower() if session.states else "",
        steps=len(session.tasks[-1].value.steps) if session.tasks else 0,
        assists=len(session.assists[-1].value) if session.assists else 0,
        estimates=len(estimates),
        wizard_events=len(session.replies),
        refused_events=sum(not r.value.accepted for r in session.replies),
        notes=sum(e.kind == "note" for e in events),
        strategy=last.strategy if last else "",
        confidence=last.confidence if last else None,
        confident=last.confident if last else None,
        correct=last.correct if last else None,
        superseded=is_superseded(session.facts),
        problems="; ".join(session.problems),
    )
    return SessionTables(
        sessions=(row,),
        steps=step_rows(session),
        assists=tuple(assists),
        estimates=tuple(estimates),
        correspondences=correspondence_rows(session),
        events=events,
        markers=marker_rows(events),
        forms=forms,
        scores=scores,
    )


def pairs_text(mapping: Mapping) -> str:
    """A mapping in one cell: source>target, in source order."""
    return " ".join(f"{source}>{target}" for source, target in mapping.pairs)


def _correct(answers: Answers | None, mapping: Mapping, used: Sequence[str] | None) -> bool | None:
    """Whether it is right; None when nobody knows, or where an older version made no such reading."""
    if answers is None or used is None or mapping == NO_MAPPING:
        return None
    return answers.maps_right(mapping, used)
