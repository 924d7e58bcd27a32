"""What a participant answered: taken item by item from what a page sent, and scored."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mbd_model.forms.form import FormError, FormItem, ItemKind, ScoreOfItems, ScoreRule, StudyForm

TEXT_LENGTH = 2000  # characters of a free answer that are kept
YES_AND_NO = {"en": ("yes", "no"), "de": ("ja", "nein")}


@dataclass(frozen=True)
class FormAnswer:
    """The answer to one item.

    Attributes:
        item: its name.
        kind: what it asked for.
        text: as it was shown.
        value: the answer, "" when left open: words, an option's name, a number, or yes and no.
        shown: the answer in the form's language.
        number: of a scale or a number, 1 and 0 of yes and no; NaN where there is none.
    """

    item: str
    kind: ItemKind
    text: str
    value: str = ""
    shown: str = ""
    number: float = math.nan

    @property
    def answered(self) -> bool:
        """Not left open."""
        return bool(self.value)


@dataclass(frozen=True)
class FilledForm:
    """A form sent in.

    Attributes:
        form, version, language: which, and how it was shown.
        answers: of every item in the form's order; () when ``declined``.
        scores: (name, value) of those whose items are all answered.
        declined: the participant did not agree, or did not want to answer.
    """

    form: str
    version: str
    language: str
    answers: tuple[FormAnswer, ...] = ()
    scores: tuple[tuple[str, float], ...] = ()
    declined: bool = False


def filled(form: StudyForm, language: str, given: Mapping[str, object]) -> FilledForm:
    """A form with what was given for its items, by name; items that are not given are left open.

    Raises:
        FormError: an item there is not, an answer that is none of its item's, or a required one that lacks.
    """
    unknown = sorted(set(given) - {item.name for item in form.items})
    if unknown:
        raise FormError(f"form '{form.name}' has no item {unknown}; it has {[i.name for i in form.items]}")
    answers = tuple(_answer(form, item, language, given.get(item.name)) for item in form.items)
    open_items = [
        i.text.in_language(language)
        for i, a in zip(form.items, answers, strict=True)
        if (i.required or (form.consent and i.kind is ItemKind.AGREE))
        and (not a.answered or (i.kind is ItemKind.AGREE and not a.number))
    ]
    if open_items:
        raise FormError(f"still open: {'; '.join(open_items)}")
    return FilledForm(form.name, form.version, language, answers, scores_of(form, answers))


def declined(form: StudyForm, language: str) -> FilledForm:
    """A form handed back without answers."""
    return FilledForm(form.name, form.version, language, declined=True)


def scores_of(form: StudyForm, answers: tuple[FormAnswer, ...]) -> tuple[tuple[str, float], ...]:
    """(name, value) of each score whose items are all answered."""
    numbers = {a.item: a.number for a in answers if a.answered and math.isfinite(a.number)}
    return tuple((s.name, _score(form, s, numbers)) for s in form.scores if set(s.items) <= set(numbers))


def _score(form: StudyForm, score: ScoreOfItems, numbers: Mapping[str, float]) -> float:
    scales = {item.name: item.scale for item in form.items if item.scale is not None}
    parts = []
    for name in score.items:
        scale, value = scales[name], numbers[name]
        turned = scale.low + scale.high - value if name in score.reversed_items else value
        parts.append(turned - scale.low if score.rule is ScoreRule.SUM_FROM_ZERO else turned)
    total = math.fsum(parts)
    return score.factor * (total / len(parts) if score.rule is ScoreRule.MEAN else total)


def _answer(form: StudyForm, item: FormItem, language: str, value: object) -> FormAnswer:
    text = item.text.in_language(language)
    if value is None or value == "":
        return FormAnswer(item.name, item.kind, text)
    where = f"form '{form.name}', item '{item.name}': "
    if item.kind is ItemKind.TEXT:
        words, shown, number = _words(value, where)
    elif item.kind is ItemKind.CHOICE:
        words, shown, number = _chosen(item, language, value, where)
    elif item.kind in (ItemKind.SCALE, ItemKind.NUMBER):
        words, shown, number = _number(item, value, where)
    else:
        words, shown, number = _yes_or_no(language, value, where)
    return FormAnswer(item.name, item.kind, text, words, shown, number)


def _words(value: object, where: str) -> tuple[str, str, float]:
    if not isinstance(value, str):
        raise FormError(f"{where}{value!r} is no text")
    lines = ("".join(c if c.isprintable() else " " for c in line).split() for line in value.splitlines())
    clean = "\n".join(" ".join(words) for words in lines).strip()
    if len(clean) > TEXT_LENGTH:
        raise FormError(f"{where}the text has {len(clean)} characters, at most {TEXT_LENGTH} are kept: shorten it")
    return clean, clean, math.nan


def _chosen(item: FormItem, language: str, value: object, where: str) -> tuple[str, str, float]:
    options = dict(item.options)
    if not isinstance(value, str) or value not in options:
        raise FormError(f"{where}{value!r} is none of {', '.join(options)}")
    return value, options[value].in_language(language), math.nan


def number_in(value: object) -> float:
    """The number that somebody typed or sent; NaN for what is none, a truth value, or beyond a float's range."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return math.nan
    try:
        return float(value)
    except (ValueError, OverflowError):
        return math.nan


def _number(item: FormItem, value: object, where: str) -> tuple[str, str, float]:
    number = number_in(value)
    if item.scale is not None:
        if not any(abs(number - v) < 1e-9 for v in item.scale.values):
            raise FormError(f"{where}{value!r} is no step of {item.scale.low:g}..{item.scale.high:g}")
    elif not (math.isfinite(number) and item.limits[0] <= number <= item.limits[1]):
        raise FormError(f"{where}{value!r} is no number from {item.limits[0]:g} to {item.limits[1]:g}")
    return f"{number:g}", f"{number:g}", number


def _yes_or_no(language: str, value: object, where: str) -> tuple[str, str, float]:
    if value not in (True, False, "yes", "no"):
        raise FormError(f"{where}{value!r} is neither yes nor no")
    yes = value in (True, "yes")
    return ("yes" if yes else "no", YES_AND_NO.get(language, YES_AND_NO["en"])[0 if yes else 1], float(yes))
