"""Two pages, on NiceGUI: the operator's console and the participant's view."""

from __future__ import annotations

from collections.abc import Callable

from mbd_model.errors import MbdError
from nicegui import events, ui

from mbd_console import panels
from mbd_console.actions import ACTIONS, KEYS, Action, offered
from mbd_console.confidence_drawing import confidence_drawing
from mbd_console.desk import Desk
from mbd_console.live_drawing import live_overlay
from mbd_console.mapping_drawing import mapping_drawing
from mbd_console.requests import NOTE_LENGTH, next_meant_step, read_request
from mbd_console.stop_bar import StopBar

PERIOD = 0.1  # [s] between two looks at what changed
GROUPS = (
    ("Session", (Action.NEXT, Action.START, Action.STOP, Action.PAUSE)),
    ("Gripper", (Action.OPEN, Action.CLOSE)),
    ("Assists", (Action.YES, Action.NO, Action.UNDO, Action.MEANT, Action.SKIP)),
    ("Repair", (Action.DELETE_LAST_STEP, Action.RERECORD_STEP, Action.BACK, Action.REDO, Action.ABORT)),
)
# Which question the page shows, so that a yes or no that comes too late is not taken for the next one.
QUESTION = "Number(document.querySelector('[data-question]')?.dataset.question ?? -1)"
CAMERA = (
    '<div class="camera"><img id="live" alt="live picture of the table"><div class="nopicture">no picture from the '
    "camera yet</div></div>"
)


class Panel:
    """A part of a page whose HTML is sent only when it changed. Its text is escaped where it is made."""

    def __init__(self, name: str, make: Callable[[], str]) -> None:
        self._make, self._last = make, ""
        self._element = ui.html("", sanitize=False).classes(f"panel {name}")

    def refresh(self) -> None:
        """Make it again."""
        content = self._make()
        if content != self._last:
            self._last = content
            self._element.set_content(content)


class OperatorPage:
    """One operator's page; all of them show the same desk."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._seen = (-1, -2)
        self._meant = -1
        self._armed: Action | None = None
        self._buttons: dict[Action, tuple[ui.button, ui.label]] = {}
        self._build()
        ui.on("console", self._on_console)
        ui.timer(PERIOD, self._refresh)

    def _build(self) -> None:
        desk = self._desk
        StopBar(desk)
        with ui.element("main").classes("console"):
            with ui.element("header"):
                ui.html('<span class="brand">Mapping by demonstration</span>', sanitize=False)
                self._panels = [Panel("path", lambda: panels.phase_bar(desk.state))]
                self._panels.append(Panel("recorder", lambda: panels.recorder_line(desk.state)))
                self._whose = ui.label().classes("whose")
                self._clock = ui.label().classes("clock")
                ui.link("steps", "/steps").classes("other")
                ui.link("participant’s view ↗", "/observe", new_tab=True).classes("other")
            self._panels.append(
                Panel("banner", lambda: panels.prompt_banner(desk.state, self._meant, answered_here=True))
            )
            with ui.element("section").classes("left"):
                with ui.element("div").classes("stage"):
                    ui.html(CAMERA, sanitize=False)
                    self._panels.append(Panel("over", lambda: live_overlay(desk.state, clickable=True)))
                self._panels.append(Panel("answer", lambda: panels.last_reply(desk.state)))
                with ui.element("div").classes("groups"):
                    for title, actions in GROUPS:
                        with ui.element("fieldset").classes(f"group {title.lower()}"):
                            ui.html(title, tag="legend", sanitize=False)
                            for action in actions:
                                self._button(action)
            with ui.element("section").classes("right"):
                self._panels += [
                    Panel("drawing card", lambda: mapping_drawing(desk.state, desk.picture_addresses())),
                    Panel(
                        "steps-panel card",
                        lambda: panels.steps_panel(desk.state, self._meant) + panels.assists_panel(desk.state),
                    ),
                ]
                with ui.element("div").classes("card sure"):
                    ui.html("Confidence", tag="h2", sanitize=False)
                    self._panels += [
                        Panel("words", lambda: panels.belief_line(desk.state)),
                        Panel("curve", lambda: confidence_drawing(desk.state.confidences, desk.state.threshold)),
                    ]
                with ui.element("div").classes("card events"):
                    self._panels.append(Panel("log-panel", lambda: panels.log_panel(desk.state)))
                    self._note = (
                        ui.input(placeholder=f"Note ({ACTIONS[Action.NOTE].key_label} to write, Enter keeps)")
                        .props(f'dense outlined maxlength={NOTE_LENGTH} input-class="note-input" aria-label="note"')
                        .classes("note")
                        .on("keydown.enter", self._on_note)
                    )

    def _button(self, action: Action) -> None:
        spec = ACTIONS[action]
        button = ui.button(color=None).props(
            f'no-caps unelevated data-action={action} aria-keyshortcuts="{spec.key_label}"'
        )
        with button.classes(f"do {action}"):
            label = ui.label(spec.label)
            ui.html(spec.key_label, tag="kbd", sanitize=False)
        button.props["title"] = spec.hint
        button.on("click", js_handler=f"() => emitEvent('console', {{action: '{action}', question: {QUESTION}}})")
        self._buttons[action] = (button, label)

    def _refresh(self) -> None:
        desk = self._desk
        self._whose.set_text(desk.state.session.session if desk.state.session else "")
        self._clock.set_text(self._time())
        if self._seen == (desk.version, self._meant):
            return
        self._seen = (desk.version, self._meant)
        if self._meant >= 0 and not offered(desk.state, Action.MEANT):
            self._meant = -1
        for panel in self._panels:
            panel.refresh()
        paused = bool(desk.state.standing) or (desk.state.session is not None and desk.state.session.paused)
        for action, (button, label) in self._buttons.items():
            spec = ACTIONS[action]
            button.set_enabled(offered(desk.state, action))
            text = "Resume" if paused and action is Action.PAUSE else spec.label
            label.set_text("Press again" if self._armed is action else text)
            self._mark(action, "armed", self._armed is action)
        for action, closed in ((Action.CLOSE, True), (Action.OPEN, False)):
            self._mark(action, "on", desk.state.closed is closed)
        self._mark(Action.PAUSE, "on", paused)

    def _mark(self, action: Action, name: str, on: bool) -> None:
        button, _ = self._buttons[action]
        button.classes(add=name) if on else button.classes(remove=name)

    def _time(self) -> str:
        state = self._desk.state
        if state.session is None:
            return "–:––"
        now = self._desk.now()
        total, phase = panels.clock(now - state.began), panels.clock(now - state.phase_began)
        return f"{total} · phase {phase}"

    def _on_note(self) -> None:
        text = self._note.value
        if self._take({"action": Action.NOTE, "text": text}):
            self._note.value = ""
        ui.run_javascript("document.activeElement.blur()")

    def _on_console(self, event: events.GenericEventArguments) -> None:
        self._take(event.args)

    def _take(self, raw: object) -> bool:
        """Pass a request on, or show on the page why not."""
        raw = _named(raw)
        action = raw.get("action") if isinstance(raw, dict) else None
        try:
            if action == "escape":
                self._meant, self._armed = -1, None
            elif action == Action.MEANT:
                self._meant = next_meant_step(raw, self._desk.state, self._meant)
            else:
                request = read_request(raw, self._desk.state, self._meant)
                if not self._confirmed(action):
                    return False
                self._desk.send(request)
                self._meant = self._meant if action in (Action.OPEN, Action.CLOSE, Action.NOTE) else -1
        except MbdError as refusal:
            self._desk.refuse(str(refusal))
            return False
        finally:
            self._seen = (-1, -2)
        return True

    def _confirmed(self, action: object) -> bool:
        """Whether an action that cannot be taken back was asked for twice in a row."""
        wanted = Action(action) if isinstance(action, str) and action in ACTIONS else None
        # After a stop the key that pauses would let the robot go on: once is a slip.
        resuming = wanted is Action.PAUSE and bool(self._desk.state.standing)
        twice = wanted is not None and (resuming or ACTIONS[wanted].confirm)
        if not twice or self._armed is wanted:
            self._armed = None
            return True
        self._armed = wanted
        return False


def _named(raw: object) -> object:
    """A key pressed, as the action it stands for."""
    if isinstance(raw, dict) and raw.get("action") == "key":
        key = raw.get("key")
        if isinstance(key, str) and key in KEYS:
            return {**raw, "action": KEYS[key]}
        if isinstance(key, str) and len(key) == 1 and key.isdecimal():
            return {**raw, "action": "object", "number": key}
        if key == "Escape":
            return {"action": "escape"}
    return raw


def observer_page(desk: Desk) -> None:
    """What the participant sees: what the robot asks and believes, and nothing to press; a key stops the robot."""
    StopBar(desk, button=False)
    with ui.element("main").classes("observer"):
        shown = [
            Panel("banner", lambda: panels.prompt_banner(desk.state)),
            Panel("heading", lambda: "<h1>This is what I believe</h1>" + panels.belief_line(desk.state)),
            Panel("drawing card", lambda: mapping_drawing(desk.state, desk.picture_addresses())),
            Panel("path", lambda: panels.phase_bar(desk.state)),
        ]
    seen = -1

    def refresh() -> None:
        nonlocal seen
        if seen != desk.version:
            seen = desk.version
            for panel in shown:
                panel.refresh()

    ui.timer(PERIOD, refresh)
