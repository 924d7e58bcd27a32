"""The operator's study tools, as HTML: forms, markers, quick notes, the phase's checklist, the countdown."""

from __future__ import annotations

from collections.abc import Sequence

from mbd_console.palette import safe
from mbd_console.state import ConsoleState
from mbd_console.study.form_plan import PlannedForm
from mbd_console.study.markers import MARKERS, PHRASES, checks
from mbd_console.words.texts import PageTexts


def study_panel(state: ConsoleState, plan: Sequence[PlannedForm], texts: PageTexts) -> str:
    """All tools but the countdown's field; every one is a button or a box that a page's script passes on."""
    markers = "".join(
        f'<button type="button" data-study="marker" data-name="{name}" aria-keyshortcuts="{key.upper()}">'
        f"{safe(texts(f'marker_{name}'))} <kbd>{key.upper()}</kbd></button>"
        for key, name in MARKERS.items()
    )
    phrases = "".join(
        f'<button type="button" data-study="phrase" data-name="{name}">{safe(texts(name))}</button>' for name in PHRASES
    )
    ticks = "".join(
        f'<li><label><input type="checkbox" data-study="tick" data-name="{name}"'
        f"{' checked' if name in state.study.ticked else ''}> {safe(words)}</label></li>"
        for name, words in checks(state.phase, texts)
    )
    return (
        f"<h2>{safe(texts('forms'))}</h2>{_forms(state, plan, texts)}<h2>{safe(texts('markers'))}</h2>"
        f'<div class="row">{markers}</div><h2>{safe(texts("phrases"))}</h2><div class="row">{phrases}</div>'
        f'<h2>{safe(texts("checklist"))}</h2><ul class="checks">{ticks}</ul>'
    )


def _forms(state: ConsoleState, plan: Sequence[PlannedForm], texts: PageTexts) -> str:
    if not plan:
        return f"<p>{safe(texts('no_forms'))}</p>"
    rows = []
    for planned in plan:
        name, title = planned.form.name, planned.form.title.in_language(texts.language)
        shown = state.study.shown == name
        stands = "form_shown" if shown else "form_in" if name in state.study.sent else ""
        stands = "form_declined" if not stands and name in state.study.declined else stands
        words = texts("hide_form" if shown else "show_form")
        rows.append(
            f'<li><span>{safe(title)}</span><b class="{stands}">{safe(texts(stands)) if stands else ""}</b>'
            f'<button type="button" data-study="form" data-name="{"" if shown else safe(name)}" '
            f'aria-label="{safe(f"{words}: {title}")}">{safe(words)}</button></li>'
        )
    return f'<ul class="form-list">{"".join(rows)}</ul>'


def countdown_words(state: ConsoleState, texts: PageTexts, now: float) -> str:
    """How long is left, "" while no countdown runs.

    Args:
        state: what the pages show.
        texts: in which language.
        now: [s, session clock].
    """
    if state.study.ends is None:
        return ""
    left = int(state.study.ends - now + 0.999)
    return texts("countdown_left", left=f"{left // 60}:{left % 60:02d}") if left > 0 else texts("countdown_over")
