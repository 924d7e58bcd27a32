"""The stop: one key, the same on every page, and a button, and why everything stands while it does."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from mbd_console.desk import Desk
from mbd_console.palette import safe
from mbd_console.requests import StopRobot
from mbd_console.words.texts import ENGLISH, PageTexts

PERIOD = 0.1  # [s] between two looks at what changed
# A function key: no letter is typed by it, so that it stops also while a note is being written.
KEY = "F8"
LISTEN = f"""<script>
document.addEventListener("keydown", (event) => {{
  if (event.key !== "{KEY}" || event.repeat) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  emitEvent("stop", {{}});
}}, true);
</script>"""


class StopBar:
    """A page's part that stops the robot. Going on is the operator's word, on the console.

    Args:
        desk: that all pages share.
        texts: in which language.
        leads: for who leads the session, with the reason and what to do; else in the participant's words.
        beside: builds what else the bar has, at its end.
    """

    def __init__(
        self,
        desk: Desk,
        texts: PageTexts = ENGLISH,
        *,
        leads: bool = True,
        beside: Callable[[], None] | None = None,
    ) -> None:
        self._desk, self._texts, self._leads = desk, texts, leads
        self._seen: str | None = None
        ui.add_head_html(LISTEN)
        with ui.element("header" if beside else "div").classes("stop-bar"):
            pressed = ui.button(texts("stop_button", key=KEY), color=None).props(
                f'no-caps unelevated data-action=stop_robot aria-keyshortcuts="{KEY}"'
            )
            pressed.classes("stop-robot").on("click", self._stop)
            pressed.props["title"] = texts("stop_tip")
            if not leads:
                ui.label(texts("stop_hint")).classes("stop-hint")
            self._why = ui.html("", sanitize=False).classes("standing").props('role=alert aria-live="assertive"')
            if beside is not None:
                beside()
        ui.on("stop", self._stop)
        ui.timer(PERIOD, self._refresh)
        self._refresh()

    def _stop(self) -> None:
        self._desk.send(StopRobot())

    def _refresh(self) -> None:
        why = self._desk.state.standing
        if why != self._seen:
            self._seen = why
            stands = safe(self._texts("stands"))
            what = self._texts("stands_what" if self._leads else "stands_participant")
            reason = f"{safe(why[:1].upper() + why[1:])}. " if self._leads else ""
            self._why.set_content(f"<b>{stands}</b> {reason}{safe(what)}" if why else "")
