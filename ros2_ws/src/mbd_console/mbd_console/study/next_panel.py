"""The button that begins the session the plan has next, shown once the present one is over."""

from __future__ import annotations

from mbd_model.session import Phase

from mbd_console.palette import safe
from mbd_console.state import ConsoleState
from mbd_console.words.texts import PageTexts

OVER = (Phase.DONE, Phase.ABORTED)


def next_panel(state: ConsoleState, texts: PageTexts) -> str:
    """The panel; "" while the session runs, or nobody leads it by a plan."""
    offered = state.offered
    if offered is None or state.phase not in OVER:
        return ""
    if offered.problem or not offered.session:
        return f'<p class="next-session">{safe(offered.problem or texts("next_none"))}</p>'
    same = state.session is not None and state.session.session.startswith(f"{offered.participant}_")
    words = texts("next_session" if same else "next_participant", participant=offered.participant)
    about = texts("next_about", task=offered.task, condition=offered.condition)
    return (
        f'<div class="next-session"><button type="button" data-study="begin" data-name="{safe(offered.session)}">'
        f"{safe(words)}</button> <span>{safe(about)}</span></div>"
    )
