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
from mbd_console.parts.page_parts import PERIOD, language_links, veil
from mbd_console.requests import CorrectStep, RequestRefusedError
from mbd_console.steps.rows import CarryRow, ObjectChoice, StepMoment, corrected_now, recorded_again_now, rows
from mbd_console.stop_bar import StopBar
from mbd_console.words.texts import ENGLISH, PageTexts

WAYS = ("earlier", "later", "join", "again", "delete")  # names of the texts
CONFIRMED = (CorrectionKind.DELETE, CorrectionKind.RERECORD)  # asked for twice: they cannot be taken back


class StepsPage:
    """One page of the steps; all of them show the same desk.

    Args:
        desk: that all pages share.
        texts: in which language.
    """

    def __init__(self, desk: Desk, texts: PageTexts = ENGLISH) -> None:
        self._desk, self._texts = desk, texts
        self._seen: object = None
        self._version = -1
        self._armed: tuple[StepCorrection, ui.button, str] | None = None
        self._pressed = ""
        StopBar(desk, texts)
        veil(texts, "lost_text")
        with ui.element("div").classes("steps-page"):
            with ui.element("header"):
                ui.html(safe(texts("shown_title")), tag="h1", sanitize=False)
                with ui.element("div").classes("elsewhere"):
                    language_links(texts, "/steps")
                    ui.link(texts("back_to_console"), f"/?lang={texts.language}").classes("back")
            self._prompt = ui.html("", sanitize=False).classes("panel banner")
            self._reply = ui.html("", sanitize=False).classes("panel answer").props('role=status aria-live="polite"')
            self._list = ui.element("ol").classes("carries").props(f'aria-label="{safe(texts("steps_title"))}"')
            self._problems = ui.html("", sanitize=False).classes("panel")
        ui.timer(PERIOD, self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        state = self._desk.state
        if self._version == self._desk.version:
            return
        self._version = self._desk.version
        self._prompt.set_content(panels.prompt_banner(state, texts=self._texts))
        self._reply.set_content(panels.last_reply(state))
        shown = (self._task(), corrected_now(state), recorded_again_now(state))
        if shown != self._seen:
            self._seen = shown
            self._build()

    def _task(self) -> Task | None:
        state = self._desk.state
        return state.recorded if state.recording else state.task

    def _build(self) -> None:
        state, task, texts = self._desk.state, self._task(), self._texts
        why_not = corrected_now(state, texts)
        self._list.clear()
        self._armed = None
        with self._list:
            if task is None or not task.steps:
                none = texts("no_step" if state.recording else "nothing_shown")
                ui.html(safe(none), tag="li", sanitize=False)
            else:
                for number, row in enumerate(rows(task, texts)):
                    with ui.element("li").classes("carry").props(f"data-carry={number}"):
                        self._carry(row, number, task, not why_not)
        notes = "".join(f"<li>{safe(p)}</li>" for p in (task.problems if task else ()))
        if self._pressed:  # whoever works by keyboard goes on where the pressed button was
            ui.run_javascript(f"document.querySelector('[data-correction=\"{self._pressed}\"]')?.focus()")
            self._pressed = ""
        closed = f'<p class="closed">{safe(texts("closed", why=why_not))}</p>' if why_not and task else ""
        self._problems.set_content(
            closed + (f'<h2>{safe(texts("noted"))}</h2><ul class="noted">{notes}</ul>' if notes else "")
        )

    def _carry(self, row: CarryRow, number: int, task: Task, open_to_change: bool) -> None:
        with ui.element("div").classes("moments"):
            for moment in row.moments:
                ui.html(_figure(moment, self._texts.language), sanitize=False)
        with ui.element("div").classes("words"):
            ui.html(f"<b>{number + 1}.</b> {safe(row.sentence)}", tag="p", sanitize=False).classes("sentence")
            if not open_to_change:
                return
            for choice in row.choices:
                if choice.doubted:
                    self._doubt(choice, task)
            named = f'role=group aria-label="{safe(self._texts("corrections"))}"'
            with ui.element("div").classes("corrections").props(named):
                again = row.again if recorded_again_now(self._desk.state) else None
                ways = (row.earlier, row.later, row.join, again, row.delete)
                for name, way in zip(WAYS, ways, strict=True):
                    self._button(self._texts(f"correct_{name}"), way, task, self._texts(f"correct_{name}_tip"))
            for choice in row.choices:
                self._choice(choice, task)
            if row.split:
                self._split(row, row.split, task)

    def _doubt(self, choice: ObjectChoice, task: Task) -> None:
        with ui.element("div").classes("doubt-of-step"):
            (_, first), (_, second) = choice.doubted
            ui.label(self._texts("in_doubt", thing=first, other=second, share=f"{choice.doubt:.0%}"))
            for object_id, name in choice.doubted:
                self._button(name, choice.change(object_id), task, self._texts("in_doubt_tip"))

    def _choice(self, choice: ObjectChoice, task: Task) -> None:
        with ui.element("details").classes("choice"):
            ui.html(f"{safe(choice.label)} …", tag="summary", sanitize=False)
            for object_id, name in choice.options:
                if object_id != choice.present:
                    tip = self._texts("choice_tip", step=choice.step + 1)
                    self._button(name, choice.change(object_id), task, tip)

    def _split(self, row: CarryRow, way: tuple[float, float], task: Task) -> None:
        length, texts = way[1] - way[0], self._texts
        with ui.element("details").classes("choice split"):
            ui.html(f"{safe(texts('split_title'))} …", tag="summary", sanitize=False)
            seconds = ui.number(texts("split_seconds"), value=round(length / 2, 1), min=0.1, max=length, step=0.1)
            seconds.props(f'dense outlined aria-label="{safe(texts("split_of", length=f"{length:.1f}"))}"')

            def ask() -> None:
                value = seconds.value
                if not isinstance(value, int | float) or not 0.0 < value < length:
                    self._desk.refuse(f"split after {value} s: the carry takes {length:.1f} s, so name less than that")
                    return
                self._ask(row.split_at(way[0] + float(value)), task)

            self._plain(texts("split_do"), f"SPLIT-{row.place}", texts("split_tip")).on_click(ask)

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
            button.set_text(self._texts("press_again_for", label=label))
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


def _figure(moment: StepMoment, language: str) -> str:
    address = f"/moment/{to_nanoseconds(moment.at)}?lang={language}"
    return (
        f'<figure><img src="{address}" alt="{safe(moment.caption)}" loading="lazy">'
        f"<figcaption>{safe(moment.caption)}</figcaption></figure>"
    )
