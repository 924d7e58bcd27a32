"""What a page asks for of the study's tools, validated: it changes the board, is noted in the bag, or both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mbd_model.forms.answers import declined, filled, number_in
from mbd_model.session import Phase

from mbd_console.requests import BeginSession, RequestRefusedError, SubmitForm, WriteNote
from mbd_console.state import ConsoleState
from mbd_console.study import board as study_board
from mbd_console.study.board import StudyBoard
from mbd_console.study.form_plan import PlannedForm
from mbd_console.study.markers import CHECKLIST, COUNTDOWN, MARKERS, PHRASES, checks
from mbd_console.words.texts import PageTexts, texts_in

LONGEST = 180.0  # [min] of a countdown


@dataclass(frozen=True)
class StudyChange:
    """What a request comes to: the board afterwards, what is noted, which session begins; None where nothing is."""

    board: StudyBoard | None = None
    note: WriteNote | None = None
    begins: BeginSession | None = None


def read_study(
    raw: object, state: ConsoleState, plan: Sequence[PlannedForm], texts: PageTexts, now: float
) -> StudyChange:
    """The change in what an operator's page sent.

    Args:
        raw: a mapping with "do": "marker", "phrase", "tick", "form", "begin" (each with "name"), or "countdown"
            ("minutes").
        state: what the pages show.
        plan: the study's forms.
        texts: of the page: a note is kept in the words that were pressed.
        now: [s, session clock].

    Raises:
        RequestRefusedError: it names what there is not.
    """
    read = raw if isinstance(raw, Mapping) else {}
    what, name = read.get("do"), read.get("name")
    if what == "marker" and name in MARKERS.values():
        return StudyChange(note=WriteNote(texts(f"marker_{name}"), str(name)))
    if what == "phrase" and name in PHRASES:
        return StudyChange(note=WriteNote(texts(str(name))))
    entries = dict(checks(state.phase, texts))
    if what == "tick" and name in entries:
        board = study_board.tick(state.study, str(name))
        mark = "✓" if name in board.ticked else "✗"
        return StudyChange(board, WriteNote(f"{mark} {entries[str(name)]}", CHECKLIST))
    if what == "form" and (name == "" or name in [p.form.name for p in plan]):
        return StudyChange(study_board.show(state.study, str(name), now))
    if what == "begin":
        return StudyChange(begins=_begins(name, state))
    if what == "countdown":
        return _countdown(read.get("minutes"), state, texts, now)
    raise RequestRefusedError(f"the page asked for {what!r} {name!r}, which the study has not: reload the page")


def _begins(name: object, state: ConsoleState) -> BeginSession:
    """The session offered, as the page showed it: a press of before begins none that came after."""
    offered = state.offered
    if state.phase not in (Phase.DONE, Phase.ABORTED):
        raise RequestRefusedError("the session still runs: finish or abort it before the next begins")
    if offered is None or offered.problem or not offered.session or name != offered.session:
        raise RequestRefusedError(f"no session {name!r:.40} is offered: look at what the page offers now")
    return BeginSession(offered.session)


def _countdown(minutes: object, state: ConsoleState, texts: PageTexts, now: float) -> StudyChange:
    if minutes is None:
        return StudyChange(replace(state.study, ends=None), WriteNote(texts("countdown_stop"), COUNTDOWN))
    length = number_in(minutes)
    if not 0.0 < length <= LONGEST:
        raise RequestRefusedError(f"a countdown takes more than 0 and at most {LONGEST:g} minutes, not {minutes!r:.20}")
    board = replace(state.study, ends=now + 60.0 * length)
    return StudyChange(board, WriteNote(f"{texts('countdown_start')} {length:g} min", COUNTDOWN))


def read_form_sent(raw: object, state: ConsoleState, plan: Sequence[PlannedForm]) -> SubmitForm:
    """The form in what a participant's page sent.

    Args:
        raw: a mapping with "form", "language", and "answers" by item, or "declined" true.
        state: what the pages show.
        plan: the study's forms.

    Raises:
        FormError: an answer that is none, or one that lacks.
        RequestRefusedError: the form is not the one shown now.
    """
    read = raw if isinstance(raw, Mapping) else {}
    shown = next((p.form for p in plan if p.form.name == state.study.shown), None)
    if shown is None or read.get("form") != shown.name:
        raise RequestRefusedError("this form is not asked for any more: tell the person with you")
    asked = texts_in(read.get("language")).language
    language = asked if asked in shown.languages else shown.title.texts[0][0]
    answers = read.get("answers")
    if read.get("declined") is True:
        return SubmitForm(declined(shown, language), state.study.since)
    if not isinstance(answers, Mapping):
        raise RequestRefusedError("the page sent no answers: reload it")
    return SubmitForm(filled(shown, language, {str(k): v for k, v in answers.items()}), state.study.since)
