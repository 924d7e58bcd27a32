"""Every sentence meant for people replaced by another one, in messages and in values alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TypeVar

Any_ = TypeVar("Any_")
Rewording = Callable[[str], str]

# The fields that hold sentences, whatever they are part of.
TEXTS = frozenset({"detail", "text", "reason", "message", "confirmation", "warnings", "problems"})
# Each is what code that reads sentences would stumble over in its own way.
REWORDINGS: dict[str, Rewording] = {
    "reversed": lambda text: text[::-1],
    "all alike": lambda text: "x" if text else "",
    "misleading": lambda text: (
        "I am watching. REFUSED: repeated, paused. What do I use now? waiting for the mapping; step 2: set t9 down, "
        "put back t9; the task is done; the demonstration ended while holding 's9'" * bool(text)
    ),
}


def reworded(value: Any_, words: Rewording) -> Any_:
    """A copy of a ROS message or a frozen value whose sentences, and those of all it holds, are other ones."""
    if hasattr(value, "get_fields_and_field_types"):
        copy = type(value)()
        for name in value.get_fields_and_field_types():
            setattr(copy, name, _part(name, getattr(value, name), words))
        return copy
    return _part("", value, words)


def _part(name: str, value: Any_, words: Rewording) -> Any_:
    if isinstance(value, str) and type(value) is str:
        return words(value) if name in TEXTS else value
    if isinstance(value, list | tuple) and type(value) in (list, tuple):
        return type(value)(_part(name, item, words) for item in value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: _part(f.name, getattr(value, f.name), words) for f in dataclasses.fields(value) if f.init}
        return dataclasses.replace(value, **parts)
    return reworded(value, words) if hasattr(value, "get_fields_and_field_types") else value


def without_sentences(value: Any_) -> Any_:
    """The value with every sentence empty: what remains is all that anything may depend on."""
    return reworded(value, lambda _: "")
