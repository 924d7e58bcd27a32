"""The page of the demonstrated steps at /steps: what was shown, with pictures, and every correction as a button.

Everything on it is a button or a field, so that it works by keyboard alone; nothing of it runs in the browser but what
NiceGUI brings.
"""

from __future__ import annotations

import re
from functools import partial

from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.task import Task
from mbd_model.times import to_nanoseconds
from nicegui import ui

from mbd_console import panels
from mbd_console.desk import Desk
from mbd_console.palette import safe
from mbd_console.requests import CorrectStep, RequestRefusedError
from mbd_console.steps.rows import CarryRow, ObjectChoice, corrected_now, recorded_again_now, rows
from mbd_console.stop_bar import StopBar

PERIOD = 0.1  # [s] between two looks at what changed
CONFIRMED = (CorrectionKind.DELETE, CorrectionKind.RERECORD)  # asked for twice: they cannot be taken back


class StepsPage:
    """One page of the steps; all of them show the same desk."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._seen: object = None
        self._version = -1
        self._armed: tuple[StepCorrection, ui.button, str] | None = None
        self._pressed = ""
        StopBar(desk)
        with ui.element("div").classes("steps-page"):
            with ui.element("header"):
                ui.html("What was shown", tag="h1", sanitize=False)
                ui.link("← console", "/").classes("back")
            self._prompt = ui.html("", sanitize=False).classes("panel banner")
            self._reply = ui.html("", sanitize=False).classes("panel answer").props('role=status aria-live="polite"')
            self._list = ui.element("ol").classes("carries").props('aria-label="demonstrated steps"')
            self._problems = ui.html("", sanitize=False).classes("panel")
        ui.timer(PERIOD, self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        state = self._desk.state
        if self._version == self._desk.version:
            return
        self._version = self._desk.version
        self._prompt.set_content(panels.prompt_banner(state))
        self._reply.set_content(panels.last_reply(state))
        shown = (self._task(), corrected_now(state), recorded_again_now(state))
        if shown != self._seen:
            self._seen = shown
            self._build()

    def _task(self) -> Task | None:
        state = self._desk.state
        return state.recorded if state.recording else state.task

    def _build(self) -> None:
        state, task = self._desk.state, self._task()
        why_not = corrected_now(state)
        self._list.clear()
        self._armed = None
        with self._list:
            if task is None or not task.steps:
                ui.html("no step yet" if state.recording else "nothing demonstrated yet", tag="li", sanitize=False)
            else:
                for number, row in enumerate(rows(task)):
                    with ui.element("li").classes("carry").props(f"data-carry={number}"):
                        self._carry(row, number, task, not why_not)
        notes = "".join(f"<li>{safe(p)}</li>" for p in (task.problems if task else ()))
        if self._pressed:  # whoever works by keyboard goes on where the pressed button was
            ui.run_javascript(f"document.querySelector('[data-correction=\"{self._pressed}\"]')?.focus()")
            self._pressed = ""
        closed = f'<p class="closed">Nothing can be corrected now: {safe(why_not)}.</p>' if why_not and task else ""
        self._problems.set_content(closed + (f'<h2>Noted</h2><ul class="noted">{notes}</ul>' if notes else ""))

    def _carry(self, row: CarryRow, number: int, task: Task, open_to_change: bool) -> None:
        with ui.element("div").classes("moments"):
            for moment in row.moments:
                ui.html(_figure(moment.caption, moment.at - task.steps[0].start, moment.at), sanitize=False)
        with ui.element("div").classes("words"):
            ui.html(f"<b>{number + 1}.</b> {safe(row.sentence)}", tag="p", sanitize=False).classes("sentence")
            if not open_to_change:
                return
            for choice in row.choices:
                if choice.doubted:
                    self._doubt(choice, task)
            with ui.element("div").classes("corrections").props('role=group aria-label="corrections"'):
                self._button("Earlier", row.earlier, task, "the step before comes after it")
                self._button("Later", row.later, task, "the step after comes before it")
                self._button("Join with next", row.join, task, "it was not put down in between, but carried on")
                if recorded_again_now(self._desk.state):
                    self._button("Re-record from here", row.again, task, "this step and all after it are shown again")
                self._button("Delete", row.delete, task, "the pick and its place are forgotten")
            for choice in row.choices:
                self._choice(choice, task)
            if row.split:
                self._split(row, row.split, task)

    def _doubt(self, choice: ObjectChoice, task: Task) -> None:
        with ui.element("div").classes("doubt-of-step"):
            (_, first), (_, second) = choice.doubted
            ui.label(f"In doubt: the {first}, or the {second} ({choice.doubt:.0%})?")
            for object_id, name in choice.doubted:
                self._button(f"the {name}", choice.change(object_id), task, "this one was meant")

    def _choice(self, choice: ObjectChoice, task: Task) -> None:
        with ui.element("details").classes("choice"):
            ui.html(f"{choice.label} …", tag="summary", sanitize=False)
            for object_id, name in choice.options:
                if object_id != choice.present:
                    self._button(f"the {name}", choice.change(object_id), task, f"step {choice.step + 1} is about it")

    def _split(self, row: CarryRow, way: tuple[float, float], task: Task) -> None:
        length = way[1] - way[0]
        with ui.element("details").classes("choice split"):
            ui.html("It was put down on the way …", tag="summary", sanitize=False)
            seconds = ui.number("seconds after the pick", value=round(length / 2, 1), min=0.1, max=length, step=0.1)
            seconds.props(f'dense outlined aria-label="seconds after the pick, of {length:.1f}"')

            def ask() -> None:
                value = seconds.value
                if not isinstance(value, int | float) or not 0.0 < value < length:
                    self._desk.refuse(f"split after {value} s: the carry takes {length:.1f} s, so name less than that")
                    return
                self._ask(row.split_at(way[0] + float(value)), task)

            self._plain("Split", f"SPLIT-{row.place}", "the object was put down there and taken again").on_click(ask)

    def _button(self, label: str, correction: StepCorrection | None, task: Task, hint: str) -> None:
        if correction is None:
            return
        button = self._plain(label, name_of(correction), hint)
        button.on_click(partial(self._press, correction, task, button, label))

    def _plain(self, label: str, name: str, hint: str) -> ui.button:
        button = ui.button(label, color=None).props(f'no-caps unelevated dense data-correction="{name}"')
        button.props["title"] = hint
        return button

    def _press(self, correction: StepCorrection, task: Task, button: ui.button, label: str) -> None:
        """Ask for it, or for a second press where it cannot be taken back."""
        armed, self._armed = self._armed, None
        if armed is not None:
            armed[1].set_text(armed[2])
        if correction.kind in CONFIRMED and (armed is None or armed[0] != correction):
            self._armed = (correction, button, label)
            button.set_text(f"Press again: {label}")
            return
        self._ask(correction, task)

    def _ask(self, correction: StepCorrection, task: Task) -> None:
        """Have a step of the task that the page showed corrected."""
        try:
            self._check(task)
            self._pressed = name_of(correction)
            self._desk.send(CorrectStep(correction))
        except MbdError as refusal:
            self._desk.refuse(str(refusal))

    def _check(self, task: Task) -> None:
        why_not = corrected_now(self._desk.state)
        if why_not:
            raise RequestRefusedError(f"no step can be corrected now: {why_not}")
        if task != self._desk.state.task:
            raise RequestRefusedError("the steps are others by now: look at them and press again")


def name_of(correction: StepCorrection) -> str:
    """What a correction's button is called in the page."""
    what = f"{correction.kind.name}-{correction.step}-{correction.object_id or correction.to}"
    return re.sub(r"[^\w-]", "_", what)  # an object's id may hold anything


def _figure(caption: str, seconds: float, at: float) -> str:
    when = f"{caption} after {seconds:.1f} s" if 0.0 <= seconds < 1e5 else f"{caption} at {at:.1f} s"
    return (
        f'<figure><img src="/moment/{to_nanoseconds(at)}" alt="{safe(when)}" loading="lazy">'
        f"<figcaption>{safe(when)}</figcaption></figure>"
    )
