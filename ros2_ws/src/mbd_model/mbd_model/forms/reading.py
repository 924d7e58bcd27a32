"""Forms from YAML: those shipped, by name, and a lab's own, by path. docs/forms.md describes the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from mbd_model.errors import MbdError
from mbd_model.forms.form import (
    AnswerScale,
    FormError,
    FormItem,
    ItemKind,
    LocalText,
    ScoreOfItems,
    ScoreRule,
    StudyForm,
)

SHIPPED = Path(__file__).parent / "shipped"
LARGEST = 1_000_000  # [byte] of a form's file
_FORM = frozenset(
    {"form", "version", "consent", "source", "licence", "title", "intro", "language", "scales", "items", "scores"}
)
_ITEM = frozenset({"name", "kind", "text", "required", "options", "scale", "limits"})
_SCORE = frozenset({"name", "rule", "items", "reversed", "factor"})
_SCALE = frozenset({"from", "to", "step", "low", "high"})


def shipped_forms() -> tuple[str, ...]:
    """Names of the forms that come with the package."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.yaml")))


def read_form(name: str) -> StudyForm:
    """A form by the name of a shipped one, or by its file's path, which has a slash or ends in .yaml.

    Raises:
        FormError: there is none, or its file says what no form can be.
    """
    path = Path(name).expanduser() if "/" in name or name.endswith((".yaml", ".yml")) else SHIPPED / f"{name}.yaml"
    if not path.is_file():
        raise FormError(
            f"there is no form '{name}': shipped are {', '.join(shipped_forms())}; give one, or your file's path"
        )
    try:
        if path.stat().st_size > LARGEST:
            raise FormError(f"{path} has more than {LARGEST} bytes: that is no form")
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, RecursionError) as error:
        raise FormError(f"{path} cannot be read as a form: {' '.join(str(error).split())}") from error
    try:
        return form_of(document)
    except MbdError as error:
        raise FormError(f"{path}: {error}") from error


def form_of(document: object) -> StudyForm:
    """The form that a YAML document describes; raises FormError naming the key."""
    read = _mapping(document, "the form", _FORM, ("form", "version", "title", "items"))
    language = _word(read.get("language", "en"), "language")
    scales = {
        str(name): _scale(entry, language, f"scale '{name}'")
        for name, entry in _named(read.get("scales", {}), "scales")
    }
    return StudyForm(
        name=_word(read["form"], "form"),
        version=_word(read["version"], "version"),
        title=_text(read["title"], language, "title"),
        intro=_text(read["intro"], language, "intro") if "intro" in read else None,
        items=tuple(_item(entry, scales, language) for entry in _list(read["items"], "items")),
        scores=tuple(_score(entry) for entry in _list(read.get("scores", []), "scores")),
        consent=_flag(read.get("consent", False), "consent"),
        source=str(read.get("source", "")),
        licence=str(read.get("licence", "")),
    )


def _item(entry: object, scales: Mapping[str, AnswerScale], language: str) -> FormItem:
    read = _mapping(entry, "an item", _ITEM, ("name", "kind", "text"))
    name = _word(read["name"], "name of an item")
    where = f"item '{name}'"
    kinds = {kind.name.lower(): kind for kind in ItemKind}
    if read["kind"] not in kinds:
        raise FormError(f"{where}: kind {read['kind']!r} is none of {', '.join(kinds)}")
    kind = kinds[read["kind"]]
    options = read.get("options", {})
    scale = read.get("scale")
    if isinstance(scale, str) and scale not in scales:
        raise FormError(f"{where}: scale '{scale}' is none of {', '.join(scales) or 'no scales: add it under scales'}")
    low, high = _limits(read.get("limits", [float("-inf"), float("inf")]), where)
    return FormItem(
        name=name,
        kind=kind,
        text=_text(read["text"], language, where),
        required=_flag(read.get("required", False), f"{where}: required"),
        options=tuple((str(n), _text(words, language, where)) for n, words in _named(options, f"{where}: options")),
        scale=None if scale is None else scales[scale] if isinstance(scale, str) else _scale(scale, language, where),
        limits=(low, high),
    )


def _scale(entry: object, language: str, where: str) -> AnswerScale:
    read = _mapping(entry, where, _SCALE, ("from", "to", "low", "high"))
    low, high, step = (_number(read.get(k, 1), f"{where}: {k}") for k in ("from", "to", "step"))
    return AnswerScale(low, high, step, _text(read["low"], language, where), _text(read["high"], language, where))


def _score(entry: object) -> ScoreOfItems:
    read = _mapping(entry, "a score", _SCORE, ("name", "rule", "items"))
    if read["rule"] not in set(ScoreRule):
        raise FormError(f"score '{read['name']}': rule {read['rule']!r} is none of {', '.join(ScoreRule)}")
    return ScoreOfItems(
        _word(read["name"], "name of a score"),
        ScoreRule(read["rule"]),
        tuple(str(i) for i in _list(read["items"], "items of a score")),
        tuple(str(i) for i in _list(read.get("reversed", []), "reversed")),
        _number(read.get("factor", 1), "factor of a score"),
    )


def _mapping(value: object, what: str, known: frozenset[str], needed: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise FormError(f"{what} is {type(value).__name__}: expected keys and values, {', '.join(needed)} among them")
    strange = sorted(str(k) for k in value if k not in known)
    lacking = [k for k in needed if k not in value]
    if strange or lacking:
        said = [f"unknown {', '.join(strange)}"] * bool(strange) + [f"lacks {', '.join(lacking)}"] * bool(lacking)
        raise FormError(f"{what}: {'; '.join(said)}; there are {', '.join(sorted(known))}")
    return value


def _text(value: object, language: str, where: str) -> LocalText:
    if isinstance(value, str):
        return LocalText(((language, value.strip()),))
    # YAML 1.1 reads the language "no" as false.
    texts = [("no" if k is False else k, v) for k, v in value.items()] if isinstance(value, dict) else []
    if not texts or not all(isinstance(k, str) and isinstance(v, str) for k, v in texts):
        raise FormError(f"{where}: {value!r} is no text: write words, or words by language (en: ..., de: ...)")
    return LocalText(tuple((str(k), str(v).strip()) for k, v in texts))


def _named(value: object, where: str) -> list[tuple[object, object]]:
    if not isinstance(value, dict):
        raise FormError(f"{where}: {value!r} has no names: write name: words, one a line")
    return [("yes" if k is True else "no" if k is False else k, v) for k, v in value.items()]


def _list(value: object, where: str) -> list[object]:
    if not isinstance(value, list):
        raise FormError(f"{where}: {value!r} is no list: begin each with a dash")
    return value


def _word(value: object, where: str) -> str:
    if not isinstance(value, str | int | float) or isinstance(value, bool) or not str(value):
        raise FormError(f"{where}: {value!r} is no word")
    return str(value)


def _flag(value: object, where: str) -> bool:
    if not isinstance(value, bool):
        raise FormError(f"{where}: {value!r} is neither true nor false")
    return value


def _number(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormError(f"{where}: {value!r} is no number")
    return float(value)


def _limits(value: object, where: str) -> tuple[float, float]:
    numbers = [_number(v, f"{where}: limits") for v in _list(value, f"{where}: limits")]
    if len(numbers) != 2 or not numbers[0] <= numbers[1]:
        raise FormError(f"{where}: limits {value!r} are not the least and the greatest number: write [18, 99]")
    return numbers[0], numbers[1]
