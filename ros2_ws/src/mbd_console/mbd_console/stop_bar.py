"""The stop: one key, the same on every page, and a button, and why everything stands while it does."""

from __future__ import annotations

from nicegui import ui

from mbd_console.desk import Desk
from mbd_console.palette import safe
from mbd_console.requests import StopRobot

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
        button: with the button; else by the key alone.
    """

    def __init__(self, desk: Desk, *, button: bool = True) -> None:
        self._desk = desk
        self._seen: str | None = None
        ui.add_head_html(LISTEN)
        with ui.element("div").classes("stop-bar"):
            if button:
                pressed = ui.button(f"STOP  {KEY}", color=None).props(
                    f'no-caps unelevated data-action=stop_robot aria-keyshortcuts="{KEY}"'
                )
                pressed.classes("stop-robot").on("click", self._stop)
                pressed.props["title"] = "Everything stands until the operator lets it go on"
            else:
                ui.label(f"{KEY}: stop the robot").classes("stop-hint")
            self._why = ui.html("", sanitize=False).classes("standing").props('role=alert aria-live="assertive"')
        ui.on("stop", self._stop)
        ui.timer(PERIOD, self._refresh)
        self._refresh()

    def _stop(self) -> None:
        self._desk.send(StopRobot())

    def _refresh(self) -> None:
        why = self._desk.state.standing
        if why != self._seen:
            self._seen = why
            shown = f"<b>Everything stands.</b> {safe(why)}. Make it safe; “Resume” on the console lets it go on."
            self._why.set_content(shown if why else "")
