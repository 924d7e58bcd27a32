"""A form as HTML: what a browser brings for forms, so that keyboard, touch and screen reader know how."""

from __future__ import annotations

from mbd_model.forms.form import FormItem, ItemKind, StudyForm

from mbd_console.palette import safe
from mbd_console.words.texts import PageTexts

LONG = 6  # items: more than a tablet shows at once


def form_html(form: StudyForm, texts: PageTexts) -> str:
    """The form; a page's script sends what is in it by the names of its items (static/participant.js)."""
    language = texts.language if texts.language in form.languages else form.title.texts[0][0]
    intro = f'<p class="intro">{safe(form.intro.in_language(language))}</p>' if form.intro else ""
    items = "".join(_item(form, item, language, texts) for item in form.items)
    leave = texts("form_decline" if form.consent else "form_skip")
    count = len(form.items)
    length = texts("form_length", count=count, send=texts("form_send")) if count >= LONG else ""
    intro += f'<p class="form-length">{safe(length)}</p>' if length else ""
    notes = " ".join(
        f'data-{name}="{safe(texts(f"form_{name}", send=texts("form_send")))}"' for name in ("lacks", "open", "number")
    )
    return (
        f'<form class="study-form" novalidate data-form="{safe(form.name)}" data-language="{language}" '
        f'lang="{language}" aria-labelledby="form-title">'
        f'<h2 id="form-title">{safe(form.title.in_language(language))}</h2>{intro}{items}'
        f'<div class="form-end"><p class="form-note" role="alert" {notes}></p>'
        f'<button type="submit">{safe(texts("form_send"))}</button>'
        f'<button type="button" data-decline="1">{safe(leave)}</button></div></form>'
    )


def _item(form: StudyForm, item: FormItem, language: str, texts: PageTexts) -> str:
    name = f"item-{item.name}"
    needed = item.required or (form.consent and item.kind is ItemKind.AGREE)
    text = safe(item.text.in_language(language))
    star = f' <em class="needed">{safe(texts("form_required"))}</em>' if needed else ""
    required = " required" if needed else ""
    if item.kind is ItemKind.TEXT:
        field = f'<textarea id="{name}" name="{item.name}" rows="3" maxlength="2000"{required}></textarea>'
        return f'<div class="item"><label for="{name}">{text}{star}</label>{field}</div>'
    if item.kind is ItemKind.NUMBER:
        low, high = (f"{v:g}" for v in item.limits)
        limits = "" if "inf" in (low, high) or "-inf" in (low, high) else f' min="{low}" max="{high}"'
        field = f'<input id="{name}" name="{item.name}" type="number" inputmode="decimal" step="any"{limits}{required}>'
        return f'<div class="item"><label for="{name}">{text}{star}</label>{field}</div>'
    if item.kind is ItemKind.AGREE:
        field = f'<input id="{name}" name="{item.name}" type="checkbox" value="yes"{required}>'
        return f'<div class="item agree"><label for="{name}">{field} <span>{text}{star}</span></label></div>'
    choices = _choices(item, language, texts, required)
    return f'<fieldset class="item {item.kind.name.lower()}"><legend>{text}{star}</legend>{choices}</fieldset>'


def _choices(item: FormItem, language: str, texts: PageTexts, required: str) -> str:
    if item.kind is ItemKind.SCALE and item.scale is not None:
        low, high = (safe(w.in_language(language)) for w in (item.scale.low_words, item.scale.high_words))
        values = item.scale.values
        many = " many" if len(values) > 7 else ""
        steps = "".join(
            _radio(item.name, f"{v:g}", f"{v:g}", required, hidden=_named(n, len(values), low, high))
            for n, v in enumerate(values)
        )
        ends = f'<span class="low">{low}</span>{steps}<span class="high">{high}</span>'
        return f'<div class="steps-of-scale{many}">{ends}</div>'
    if item.kind is ItemKind.YES_NO:
        options = [("yes", texts("yes")), ("no", texts("no"))]
    else:
        options = [(name, words.in_language(language)) for name, words in item.options]
    return '<div class="options">' + "".join(_radio(item.name, n, w, required) for n, w in options) + "</div>"


def _named(number: int, count: int, low: str, high: str) -> str:
    """What the ends of a scale are called for who hears them."""
    return f" {low}" if number == 0 else f" {high}" if number == count - 1 else ""


def _radio(item: str, value: str, words: str, required: str, hidden: str = "") -> str:
    spoken = f'<span class="sr-only">{hidden}</span>' if hidden else ""
    return (
        f'<label class="radio"><input type="radio" name="{item}" value="{safe(value)}"{required}>'
        f"<span>{safe(words)}{spoken}</span></label>"
    )
