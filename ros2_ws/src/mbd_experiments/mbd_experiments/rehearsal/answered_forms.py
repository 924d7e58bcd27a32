"""Forms filled in by simulated participants: made up from a seed, in the range of each item, and never meaningful."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from mbd_model.forms.answers import FilledForm, filled
from mbd_model.forms.form import FormItem, ItemKind, StudyForm

WORDS = "a made-up answer of a simulated participant"


def filled_by_chance(form: StudyForm, level: float, rng: np.random.Generator) -> FilledForm:
    """A form as somebody might send it in.

    Args:
        form: to fill in.
        level: of his answers on scales, 0 (low end) to 1; each lies about it.
        rng: of the answers.
    """
    given: dict[str, object] = {item.name: _answer(item, level, rng) for item in form.items}
    return filled(form, form.languages[0], given)


def _answer(item: FormItem, level: float, rng: np.random.Generator) -> object:
    if item.kind is ItemKind.SCALE and item.scale is not None:
        values = item.scale.values
        place = round(float(np.clip(rng.normal(level, 0.15), 0.0, 1.0)) * (len(values) - 1))
        return f"{values[place]:g}"
    if item.kind is ItemKind.CHOICE:
        return item.options[int(rng.integers(len(item.options)))][0]
    if item.kind is ItemKind.NUMBER:
        low, high = (limit if np.isfinite(limit) else usual for limit, usual in zip(item.limits, (18, 65), strict=True))
        return str(int(rng.integers(int(np.ceil(low)), int(np.floor(high)) + 1)))
    if item.kind is ItemKind.YES_NO:
        return "yes" if rng.random() < 0.5 else "no"
    return "yes" if item.kind is ItemKind.AGREE else WORDS


def level_of(participant: str, condition: str, questions: int, seed: int) -> float:
    """How high on scales a participant answers after a session: his own habit, and more the more he was asked.

    Args:
        participant: pseudonym; the same has the same habit.
        condition: of the session.
        questions: he was asked.
        seed: of the rehearsal.
    """
    habit = np.random.default_rng([seed, *participant.encode()]).normal(0.35, 0.1)
    mood = np.random.default_rng([seed, *participant.encode(), *condition.encode()]).normal(0.0, 0.05)
    return float(np.clip(habit + mood + 0.03 * questions, 0.05, 0.95))


def due_forms(forms: Mapping[str, StudyForm], first: bool, last: bool) -> tuple[StudyForm, ...]:
    """Those that a session asks for, by name.

    Args:
        forms: there are.
        first: it is the participant's first session.
        last: it is the last of its condition.
    """
    before = ("consent", "demographics") if first else ()
    after = ("nasa_tlx", "godspeed") if last else ("nasa_tlx",)
    return tuple(forms[name] for name in (*before, *after) if name in forms)
