"""Which forms a study has, and with which phase each is shown by itself: the console's parameter ``forms``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from mbd_model.forms.form import FormError, StudyForm
from mbd_model.forms.reading import read_form
from mbd_model.session import Phase


@dataclass(frozen=True)
class PlannedForm:
    """A form, and the phase in which the participant's page shows it by itself; None: only when the operator asks."""

    form: StudyForm
    phase: Phase | None = None


def form_plan(entries: Iterable[str]) -> tuple[PlannedForm, ...]:
    """The forms of ``NAME`` or ``NAME@phase`` each, NAME as `read_form` takes it; "" is none.

    Raises:
        FormError: a form or a phase there is not, or one form twice.
    """
    planned = []
    for entry in entries:
        name, _, phase = entry.strip().partition("@")
        if not name:
            continue
        phases = {p.name.lower(): p for p in Phase}
        if phase and phase not in phases:
            raise FormError(f"form '{entry}': there is no phase '{phase}'; there are {', '.join(phases)}")
        planned.append(PlannedForm(read_form(name), phases.get(phase)))
    names = [p.form.name for p in planned]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise FormError(f"forms {', '.join(twice)} are named twice; name each once")
    return tuple(planned)
