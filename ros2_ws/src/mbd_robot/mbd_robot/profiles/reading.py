"""A YAML mapping as a frozen dataclass: every key known, every value of its type, a mistake named with its place."""

from __future__ import annotations

import dataclasses
import enum
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml
from mbd_model.errors import MbdError
from mbd_model.parameters import nearest

Section = TypeVar("Section")


class ProfileError(MbdError):
    """A profile that cannot be used; the text names the file, the key and what was expected."""


def read_profile(kind: type[Section], path: Path) -> Section:
    """The profile that a file holds.

    Args:
        kind: a frozen dataclass; its fields are the keys, those without a default are required.
        path: of a YAML file.

    Raises:
        ProfileError: no such file, no YAML mapping, an unknown or missing key, a value of another type.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise ProfileError(
            f"{path} cannot be read ({error}); give the name of a profile, or an existing file"
        ) from error
    except yaml.YAMLError as error:
        raise ProfileError(f"{path} is no YAML: {error}") from error
    return section(kind, document, str(path))


def section(kind: type[Section], value: object, where: str) -> Section:
    """A mapping as a dataclass.

    Args:
        kind: the dataclass.
        value: what YAML gave.
        where: file and key, for the text of an error.

    Raises:
        ProfileError: it does not fit.
    """
    if not isinstance(value, Mapping):
        raise ProfileError(f"{where} is {_shown(value)}; expected keys such as {', '.join(_names(kind)[:3])}")
    wanted = typing.get_type_hints(kind)
    for key in value:
        if key not in wanted:
            near = nearest(str(key), wanted)
            advice = f"did you mean '{near}'?" if near else f"there are: {', '.join(wanted)}"
            raise ProfileError(f"{where} has no key '{key}'; {advice}")
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and field.name not in value:
            raise ProfileError(f"{where} lacks the key '{field.name}'")
    made = {key: _typed(wanted[key], inner, f"{where}: {key}") for key, inner in value.items()}
    try:
        return kind(**made)
    except ProfileError:
        raise
    except MbdError as error:
        raise ProfileError(f"{where}: {error}") from error


def _names(kind: type[Any]) -> list[str]:
    return [f.name for f in dataclasses.fields(kind)]


def _typed(kind: Any, value: object, where: str) -> object:
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        if value is None and type(None) in inner:
            return None
        return _typed(next(k for k in inner if k is not type(None)), value, where)
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return section(kind, value, where)
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return _choice(kind, value, where)
    if origin is tuple:
        return _sequence(inner, value, where)
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if kind is not float and type(value) is kind:
        return value
    words = {float: "a number", int: "an integer", bool: "true or false", str: "a text"}
    raise ProfileError(f"{where} is {_shown(value)}; expected {words.get(kind, str(kind))}")


def _choice(kind: type[enum.Enum], value: object, where: str) -> enum.Enum:
    choices = [str(member.value) for member in kind]
    if value in choices:
        return kind(value)
    near = nearest(str(value), choices)
    advice = f"did you mean '{near}'?" if near else f"expected one of: {', '.join(choices)}"
    raise ProfileError(f"{where} is {_shown(value)}; {advice}")


def _sequence(inner: tuple[Any, ...], value: object, where: str) -> tuple[object, ...]:
    endless = len(inner) == 2 and inner[1] is Ellipsis
    if not isinstance(value, list):
        raise ProfileError(f"{where} is {_shown(value)}; expected a list")
    if not endless and len(value) != len(inner):
        raise ProfileError(f"{where} has {len(value)} entries; expected {len(inner)}")
    kinds = [inner[0]] * len(value) if endless else list(inner)
    return tuple(_typed(k, v, f"{where}[{i}]") for i, (k, v) in enumerate(zip(kinds, value, strict=True)))


def _shown(value: object) -> str:
    return f"'{value}'" if isinstance(value, str) else str(value)
