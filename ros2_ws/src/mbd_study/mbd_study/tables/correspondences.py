"""Estimates taken apart: a row for each pair of each mapping that an estimate names."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_bag.session.recorded_session import RecordedSession

from mbd_study.tables.correctness import answers_of


@dataclass(frozen=True)
class CorrespondenceRow:
    """One pair of one mapping; ``mapping`` is "prediction", "best_guess" or "obeying"."""

    session: str
    estimate: int
    mapping: str
    source: str
    target: str
    right: bool | None


def correspondence_rows(session: RecordedSession) -> tuple[CorrespondenceRow, ...]:
    """All pairs of all estimates, estimate by estimate; ``estimate`` counts as in the table of estimates."""
    answers = answers_of(session)
    return tuple(
        CorrespondenceRow(
            session=session.name,
            estimate=number,
            mapping=name,
            source=source,
            target=target,
            right=None if answers is None else answers.is_right(source, target),
        )
        for number, (recorded, _) in enumerate(session.estimates)
        for name, mapping in (
            ("prediction", recorded.value.mapping),
            ("best_guess", recorded.value.best_guess),
            ("obeying", recorded.value.obeying),
        )
        for source, target in mapping.pairs
    )
