"""The operator's page, on NiceGUI."""

from __future__ import annotations

import time

from mbd_model.errors import MbdError
from nicegui import events, ui

from mbd_console import panels
from mbd_console.actions import ACTIONS, Action, offered
from mbd_console.confidence_drawing import confidence_drawing
from mbd_console.desk import Desk
from mbd_console.live_drawing import live_overlay
from mbd_console.mapping_drawing import DrawingWords, mapping_drawing
from mbd_console.palette import safe
from mbd_console.parts.action_buttons import ActionButtons
from mbd_console.parts.keys_dialog import keys_dialog
from mbd_console.parts.page_parts import PERIOD, Panel, language_links, veil
from mbd_console.parts.pressed_keys import action_of_key
from mbd_console.requests import NOTE_LENGTH, next_meant_step, read_request
from mbd_console.room.panel import room_panel
from mbd_console.state import on_study
from mbd_console.status.bar import announced, status_bar
from mbd_console.stop_bar import KEY, StopBar
from mbd_console.study.next_panel import next_panel
from mbd_console.study.panel import countdown_words, study_panel
from mbd_console.study.requests import read_study
from mbd_console.words.texts import ENGLISH, PageTexts


class OperatorPage:
    """One operator's page; all of them show the same desk.

    Args:
        desk: that all pages share.
        texts: in which language.
    """

    def __init__(self, desk: Desk, texts: PageTexts = ENGLISH) -> None:
        self._desk, self._texts = desk, texts
        self._seen = (-1, -2)
        self._meant = -1
        self._panels: list[Panel] = []
        self._build()
        ui.on("console", self._on_console)
        ui.on("study", self._on_study)
        ui.timer(PERIOD, self._refresh)

    def _build(self) -> None:
        StopBar(self._desk, self._texts, beside=self._build_lamps)
        veil(self._texts, "lost_text")
        ui.html(keys_dialog(self._texts, KEY), sanitize=False)
        with ui.element("div").classes("console"):  # within the one main that NiceGUI brings
            self._build_head()
            with ui.element("section").classes("left").props(f'aria-label="{safe(self._texts("live_picture"))}"'):
                self._build_stage()
            with ui.element("div").classes("right"):
                self._build_beliefs()
            self._build_study()

    def _build_lamps(self) -> None:
        desk, texts = self._desk, self._texts
        props = f'role=group aria-label="{safe(texts("status"))}"'
        self._lamps = Panel(
            "lamps",
            lambda: status_bar(
                desk.state,
                texts,
                time.monotonic(),
                desk.pictures.newest,
                desk.films,
                form=self._form_title(),
                session_age=desk.now() - desk.pictures.newest_stamp,
            ),
            props,
        )
        self._said = Panel(
            "sr-only",
            lambda: safe(announced(desk.state, texts, time.monotonic(), desk.films, form=self._form_title())),
            'role=status aria-live="polite"',
        )

    def _form_title(self) -> str:
        shown = self._desk.state.study.shown
        title = next((p.form.title for p in self._desk.forms if p.form.name == shown), None)
        return title.in_language(self._texts.language) if title else ""

    def _build_head(self) -> None:
        desk, texts = self._desk, self._texts
        with ui.element("div").classes("head"):
            ui.html(safe(texts("brand")), tag="h1", sanitize=False).classes("brand")
            self._panels.append(Panel("path", lambda: panels.phase_bar(desk.state, texts)))
            self._whose = ui.label().classes("whose")
            self._clock = ui.label().classes("clock").props("role=timer")
            ui.link(texts("page_steps"), f"/steps?lang={texts.language}").classes("other")
            ui.link(texts("page_participant"), f"/observe?lang={texts.language}", new_tab=True).classes("other")
            language_links(texts, "/")
            for name, words, key in (("study", "study_tools", "V"), ("keys", "keys", "?")):
                expanded = " aria-expanded=false" if name == "study" else ""
                ui.html(
                    f'<button type="button" class="tool" data-toggle="{name}" aria-keyshortcuts="{key}"{expanded}>'
                    f"{safe(texts(words))} <kbd>{key}</kbd></button>",
                    sanitize=False,
                )
        self._panels.append(
            Panel(
                "banner",
                lambda: (
                    panels.prompt_banner(desk.state, self._meant, texts, answered_here=True)
                    + next_panel(desk.state, texts)
                ),
                'role=status aria-live="polite"',
            )
        )

    def _build_stage(self) -> None:
        desk, texts = self._desk, self._texts
        with ui.element("div").classes("stage"):
            ui.html(
                f'<div class="camera"><img id="live" alt="{safe(texts("live_picture"))}"><div class="nopicture">'
                f"{safe(texts('no_picture'))}</div></div>",
                sanitize=False,
            )
            self._panels.append(Panel("over", lambda: live_overlay(desk.state, texts, clickable=True)))
        self._panels.append(Panel("answer", lambda: panels.last_reply(desk.state), 'role=status aria-live="polite"'))
        self._buttons = ActionButtons(texts)

    def _build_beliefs(self) -> None:
        desk, texts = self._desk, self._texts
        words = DrawingWords(texts)
        scrolled = "tabindex=0 role=region"
        self._panels += [
            Panel("drawing card", lambda: mapping_drawing(desk.state, desk.picture_addresses(), words)),
            Panel(
                "steps-panel card",
                lambda: panels.steps_panel(desk.state, self._meant, texts) + panels.assists_panel(desk.state, texts),
                f'{scrolled} aria-label="{safe(texts("steps_title"))}"',
            ),
        ]
        with ui.element("div").classes("card sure"):
            ui.html(safe(texts("confidence")), tag="h2", sanitize=False)
            self._panels += [
                Panel("words", lambda: panels.belief_line(desk.state, texts)),
                Panel("curve", lambda: confidence_drawing(desk.state.confidences, desk.state.threshold, texts)),
            ]
        with ui.element("div").classes("card events"):
            label = safe(texts("log_label"))
            self._panels.append(
                Panel(
                    "log-panel",
                    lambda: panels.log_panel(desk.state, texts),
                    f'tabindex=0 role=log aria-label="{label}"',
                )
            )
            with ui.element("div").props("data-keep=note"):
                self._note = (
                    ui.input(placeholder=texts("note_hint", key=ACTIONS[Action.NOTE].key_label))
                    .props(
                        f'dense outlined maxlength={NOTE_LENGTH} input-class="note-input" '
                        f'aria-label="{safe(texts("note"))}"'
                    )
                    .classes("note")
                    .on("keydown.enter", self._on_note)
                )

    def _build_study(self) -> None:
        desk, texts = self._desk, self._texts
        with (
            ui.element("aside")
            .classes("study-tools card")
            .props(f'hidden tabindex=-1 aria-label="{safe(texts("study_tools"))}"')
        ):
            self._panels.append(Panel("study", lambda: study_panel(desk.state, desk.forms, texts)))
            ui.html(safe(texts("countdown")), tag="h2", sanitize=False)
            with ui.element("div").classes("row"):
                self._minutes = ui.number(texts("countdown_minutes"), value=5, min=0.5, max=180, step=0.5)
                self._minutes.props("dense outlined").classes("minutes")
                for words, minutes in (("countdown_start", True), ("countdown_stop", False)):
                    ui.button(texts(words), color=None).props("no-caps unelevated dense").on_click(
                        lambda _, begins=minutes: self._on_countdown(begins)
                    )
                self._left = ui.label().classes("left-over").props("role=timer")
            ui.html(room_panel(texts), sanitize=False)

    def _refresh(self) -> None:
        desk, texts = self._desk, self._texts
        self._whose.set_text(desk.state.session.session if desk.state.session else "")
        self._clock.set_text(self._time())
        self._left.set_text(countdown_words(desk.state, texts, desk.now()))
        self._lamps.refresh()
        self._said.refresh()
        if self._buttons.forget(time.monotonic()):
            self._seen = (-1, -2)
        if self._seen == (desk.version, self._meant):
            return
        self._seen = (desk.version, self._meant)
        if self._meant >= 0 and not offered(desk.state, Action.MEANT):
            self._meant = -1
        for panel in self._panels:
            panel.refresh()
        self._buttons.refresh(desk.state)

    def _time(self) -> str:
        state = self._desk.state
        if state.session is None:
            return "–:––"
        now = self._desk.now()
        total, phase = panels.clock(now - state.began), panels.clock(now - state.phase_began)
        return self._texts("phase_time", total=total, phase=phase)

    def _on_note(self) -> None:
        text = self._note.value
        if self._take({"action": Action.NOTE, "text": text}):
            self._note.value = ""
        ui.run_javascript("document.activeElement.blur()")

    def _on_study(self, event: events.GenericEventArguments) -> None:
        self._study(event.args)

    def _on_countdown(self, begins: bool) -> None:
        self._study({"do": "countdown", "minutes": self._minutes.value if begins else None})

    def _study(self, raw: object) -> None:
        """Change the study's board and note it, or show on the page why not."""
        try:
            change = read_study(raw, self._desk.state, self._desk.forms, self._texts, self._desk.now())
            for request in (change.note, change.begins):
                if request is not None:
                    self._desk.send(request)
        except MbdError as refusal:
            self._desk.refuse(str(refusal))
            return
        board = change.board
        if board is not None:
            self._desk.post(lambda state: on_study(state, board))

    def _on_console(self, event: events.GenericEventArguments) -> None:
        self._take(event.args)

    def _take(self, raw: object) -> bool:
        """Pass a request on, or show on the page why not."""
        named = action_of_key(raw)
        if named is None and raw is not None:
            return False
        raw = named
        if isinstance(raw, dict) and raw.get("do") == "marker":
            self._study(raw)
            return True
        action = raw.get("action") if isinstance(raw, dict) else None
        try:
            if action == "escape":
                self._meant = -1
                self._buttons.disarm()
            elif action == Action.MEANT:
                self._meant = next_meant_step(raw, self._desk.state, self._meant)
            else:
                request = read_request(raw, self._desk.state, self._meant)
                if not self._buttons.confirmed(action, self._desk.state, time.monotonic()):
                    return False
                self._desk.send(request)
                self._meant = self._meant if action in (Action.OPEN, Action.CLOSE, Action.NOTE) else -1
        except MbdError as refusal:
            self._desk.refuse(str(refusal))
            return False
        finally:
            self._seen = (-1, -2)
        return True
