"""The participant's page: what the robot says, wants and believes, and the forms that are to be filled in."""

from __future__ import annotations

import time

from mbd_model.errors import MbdError
from mbd_model.session import Phase
from nicegui import events, ui

from mbd_console.desk import Desk
from mbd_console.mapping_drawing import DrawingWords, mapping_drawing
from mbd_console.palette import safe
from mbd_console.participant import panels
from mbd_console.parts.page_parts import PERIOD, Panel, language_links, veil
from mbd_console.room.shown import room_sentence
from mbd_console.stop_bar import StopBar
from mbd_console.study.form_html import form_html
from mbd_console.study.panel import countdown_words
from mbd_console.study.requests import read_form_sent
from mbd_console.words.sentences import LayNames, lay_names
from mbd_console.words.texts import PageTexts


class ParticipantPage:
    """One screen of the participant's; nothing on it leads the session but the stop.

    Args:
        desk: that all pages share.
        texts: in which language.
    """

    def __init__(self, desk: Desk, texts: PageTexts) -> None:
        self._desk, self._texts = desk, texts
        self._seen, self._form, self._said = -1, "", ""
        self._thanked: tuple[Phase | None, int] | None = None  # phase and prompt in which a form was sent in
        StopBar(desk, texts, leads=False, beside=self._switches)
        veil(texts, "lost_text_participant")
        with ui.element("div").classes("observer") as self._main:
            ui.html(safe(texts("participant_title")), tag="h1", sanitize=False).classes("sr-only")
            self._panels = [
                Panel(
                    "banner",
                    lambda: panels.dialogue_panel(desk.state, texts, self._names()),
                    'role=status aria-live="polite"',
                )
            ]
            self._countdown = ui.label().classes("countdown")
            self._filmed = Panel("filmed", self._filmed_words, 'role=status aria-live="polite"')
            self._message = (
                ui.html("", sanitize=False).classes("form-message").props('role=alert aria-live="assertive"')
            )
            self._form_place = ui.html("", sanitize=False).classes("form-place")
            with ui.element("div").classes("beliefs"):
                with ui.element("section").classes("seen card"):
                    self._panels.append(Panel("drawing", self._drawing))
                    ui.html(panels.legend(texts), sanitize=False).classes("legend-box")
                    ui.html(panels.only_shown(texts), sanitize=False).classes("only-shown").props("role=status")
                with ui.element("section").classes("thought card"):
                    self._panels.append(Panel("sure", lambda: panels.sure_panel(desk.state, texts)))
                    self._panels.append(Panel("plan", lambda: panels.plan_panel(desk.state, texts, self._names())))
                    with ui.element("details").classes("why"):
                        ui.html(safe(texts("why")), tag="summary", sanitize=False)
                        self._panels.append(Panel("because", lambda: panels.why_panel(desk.state, texts)))
            self._spoken = ui.element("div").props("hidden data-speak-text").classes("spoken")
        ui.on("form", self._on_form)
        ui.timer(PERIOD, self._refresh)

    def _switches(self) -> None:
        label = safe(self._texts("speak"))
        ui.html(
            f'<label class="speak" hidden><input type="checkbox" id="speak"> {label}</label>', sanitize=False
        ).classes("speak-box")
        language_links(self._texts, "/observe")

    def _filmed_words(self) -> str:
        said, live = room_sentence(self._desk.films, self._texts, time.monotonic())
        return f'<span class="{"live" if live else "over"}">{safe(said)}</span>' if said else ""

    def _names(self) -> LayNames:
        return lay_names(self._desk.state, self._texts)

    def _drawing(self) -> str:
        state = self._desk.state
        return mapping_drawing(state, self._desk.picture_addresses(), DrawingWords(self._texts, self._names()))

    def _refresh(self) -> None:
        desk = self._desk
        self._countdown.set_text(countdown_words(desk.state, self._texts, desk.now()))
        self._filmed.refresh()
        if self._seen == desk.version:
            return
        self._seen = desk.version
        for panel in self._panels:
            panel.refresh()
        said = panels.spoken(desk.state, self._texts, self._names())
        if said != self._said:
            self._said = said
            self._spoken.props(remove="data-speak-text")
            self._spoken.props["data-speak-text"] = said
            self._spoken.update()
        self._show_form()
        if self._thanked is not None and self._thanked != self._moment():  # the session goes on
            self._thanked = None
            self._message.set_content("")

    def _moment(self) -> tuple[Phase | None, int]:
        return self._desk.state.phase, self._desk.state.question

    def _show_form(self) -> None:
        shown = self._desk.state.study.shown
        if shown == self._form:
            return
        came_back = self._form in self._desk.state.study.answered
        form = next((p.form for p in self._desk.forms if p.form.name == shown), None)
        self._form = shown
        self._form_place.set_content(form_html(form, self._texts) if form else "")
        self._message.set_content(f"<p>{safe(self._texts('form_thanks'))}</p>" if came_back else "")
        self._thanked = self._moment() if came_back else None
        self._main.classes(add="form-open") if form else self._main.classes(remove="form-open")

    def _on_form(self, event: events.GenericEventArguments) -> None:
        try:
            self._desk.send(read_form_sent(event.args, self._desk.state, self._desk.forms))
            self._message.set_content("")
        except MbdError as refusal:
            self._message.set_content(f"<p>{safe(self._texts('form_refused', why=refusal))}</p>")
