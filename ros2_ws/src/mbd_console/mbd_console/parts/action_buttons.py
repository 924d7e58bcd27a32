"""The operator's buttons: which can be pressed, what each is called now, and which was pressed once of twice."""

from __future__ import annotations

from mbd_model.session import Phase
from nicegui import ui

from mbd_console.actions import ACTIONS, Action, offered
from mbd_console.palette import safe
from mbd_console.state import ConsoleState
from mbd_console.words.texts import PageTexts

PATIENCE = 3.0  # [s] for the second press of what is asked twice
GROUPS = (
    ("session", (Action.NEXT, Action.START, Action.STOP, Action.PAUSE)),
    ("gripper", (Action.OPEN, Action.CLOSE)),
    ("assists", (Action.YES, Action.NO, Action.UNDO, Action.MEANT, Action.SKIP)),
    ("repair", (Action.DELETE_LAST_STEP, Action.RERECORD_STEP, Action.BACK, Action.REDO, Action.ABORT)),
)
# Which question the page shows, so that a yes or no that comes too late is not taken for the next one.
QUESTION = "Number(document.querySelector('[data-question]')?.dataset.question ?? -1)"


class ActionButtons:
    """The buttons of one page.

    Args:
        texts: in which language.
    """

    def __init__(self, texts: PageTexts) -> None:
        self._texts = texts
        self._armed: Action | None = None
        self._armed_at = 0.0
        self._buttons: dict[Action, tuple[ui.button, ui.label]] = {}
        with ui.element("div").classes("groups"):
            for title, actions in GROUPS:
                with ui.element("fieldset").classes(f"group {title}"):
                    ui.html(safe(texts(f"group_{title}")), tag="legend", sanitize=False)
                    for action in actions:
                        self._button(action)

    def _button(self, action: Action) -> None:
        spec, texts = ACTIONS[action], self._texts
        button = ui.button(color=None).props(
            f'no-caps unelevated data-action={action} aria-keyshortcuts="{spec.key_label}"'
        )
        with button.classes(f"do {action}"):
            label = ui.label(spec.label(texts))
            ui.html(spec.key_label, tag="kbd", sanitize=False)
        button.props["title"] = spec.hint(texts)
        button.on("click", js_handler=f"() => emitEvent('console', {{action: '{action}', question: {QUESTION}}})")
        self._buttons[action] = (button, label)

    def refresh(self, state: ConsoleState) -> None:
        """Show what can be pressed in a state, and what it then means."""
        texts = self._texts
        paused = bool(state.standing) or (state.session is not None and state.session.paused)
        going_on = "go_on" if state.phase is Phase.ABORTED else "resume" if paused else ""
        for action, (button, label) in self._buttons.items():
            button.set_enabled(offered(state, action))
            text = texts(going_on) if going_on and action is Action.PAUSE else ACTIONS[action].label(texts)
            label.set_text(texts("press_again") if self._armed is action else text)
            self._mark(action, "armed", self._armed is action)
        for action, closed in ((Action.CLOSE, True), (Action.OPEN, False)):
            self._mark(action, "on", state.closed is closed)
        self._mark(Action.PAUSE, "on", bool(going_on))
        # It can be pressed all the same: the demonstration node knows better whether it records.
        self._mark(Action.STOP, "quiet", not state.recording)

    def _mark(self, action: Action, name: str, on: bool) -> None:
        button, _ = self._buttons[action]
        button.classes(add=name) if on else button.classes(remove=name)

    def confirmed(self, action: object, state: ConsoleState, now: float) -> bool:
        """Whether an action that cannot be taken back was asked for twice in a row; ``now`` [s]: of this press."""
        wanted = Action(action) if isinstance(action, str) and action in ACTIONS else None
        # After a stop the key that pauses would let the robot go on: once is a slip.
        resuming = wanted is Action.PAUSE and bool(state.standing)
        twice = wanted is not None and (resuming or ACTIONS[wanted].confirm)
        if not twice or self._armed is wanted:
            self._armed = None
            return True
        self._armed, self._armed_at = wanted, now
        return False

    def disarm(self) -> None:
        """Take a first press for none."""
        self._armed = None

    def forget(self, now: float) -> bool:
        """Take a first press for none that waited too long; whether there was one. ``now`` [s]: as in confirmed."""
        late = self._armed is not None and now - self._armed_at > PATIENCE
        if late:
            self._armed = None
        return late
