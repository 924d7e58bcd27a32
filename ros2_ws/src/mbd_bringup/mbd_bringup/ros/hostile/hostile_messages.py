"""Messages that fit their type and that nobody would send on purpose, from a seed."""

from __future__ import annotations

import array
import re
from importlib import import_module
from typing import Any, Final

import numpy as np

_LIST: Final = re.compile(r"sequence<(?P<each>[^,>]+)(?:, *(?P<bound>\d+))?>|(?P<of>.+)\[(?P<count>\d+)\]")
_FLOATS: Final = (0.0, -0.0, 1.0, -1.0, 0.1, np.nan, np.inf, -np.inf, 1e38, -1e38, 1e-38)
_DOUBLES: Final = (*_FLOATS, 1e308, -1e308, 5e-324, 1e12)
# Some that are names of a session, so that what is sent is taken in before it turns out to be nonsense.
_TEXTS: Final = (
    "", "s1", "s2", "s9", "t1", "t2", "t9", "bin", "map", "j2n6s300_link_base", "camera_color_optical_frame", "sorting",
    "rgb8", "16UC1", "mono8", "jpeg", "\n", "\t", "../../etc/passwd", "<script>alert(1)</script>", "%s%n{0}", "ÄΩ漢🙂",
    "-1", "nan", "null", "[[", "/a//b", "x" * 5000, "\x1b[31m", "'; --", "j2n6s300_joint_1", "\x7f\x01",
)  # fmt: skip
_LENGTHS: Final = (0, 0, 1, 1, 2, 2, 3, 4, 17)
_TYPE_CODES: Final = {
    "int8": "b", "uint8": "B", "octet": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q",
    "uint64": "Q", "float": "f", "double": "d",
}  # fmt: skip


def message_class(name: str) -> Any:
    """The class of ``package/Type`` or ``package/msg/Type``; raises ImportError or AttributeError for neither."""
    package, *kind, short = name.split("/")
    for part in () if kind else ("Goal", "Feedback", "Result"):
        if short.endswith(f"_{part}"):
            return getattr(getattr(import_module(f"{package}.action"), short.removesuffix(f"_{part}")), part)
    return getattr(import_module(f"{package}.{kind[0] if kind else 'msg'}"), short)


def hostile_message(kind: Any, rng: np.random.Generator, depth: int = 0) -> Any:
    """A message (or request) of a type, each of its fields anything its type allows.

    Args:
        kind: its class.
        rng: decides.
        depth: how deep it lies in another: lists end there in time.
    """
    made = kind()
    for name, described in kind.get_fields_and_field_types().items():
        if rng.random() < 0.15:
            continue  # as it is by default
        setattr(made, name, _value(described, rng, depth))
    return made


def _value(described: str, rng: np.random.Generator, depth: int) -> Any:
    listed = _LIST.fullmatch(described)
    if listed is None:
        return _single(described, rng, depth)
    each = listed["each"] or listed["of"]
    count = int(listed["count"]) if listed["count"] else int(rng.choice(_LENGTHS)) if depth < 3 else 0
    if listed["bound"]:
        count = min(count, int(listed["bound"]))
    if each in ("uint8", "octet") and not listed["count"] and rng.random() < 0.5:
        count = int(rng.choice([100, 3072, 70_000]))
    if each in _TYPE_CODES:
        if count > 50:
            values: Any = np.frombuffer(rng.bytes(count), np.uint8).tolist()
        else:
            values = [_single(each, rng, depth) for _ in range(count)]
        if listed["count"]:
            return np.array(values, dtype={"float": np.float32, "double": np.float64}.get(each, each))
        return array.array(_TYPE_CODES[each], values)
    return [_single(each, rng, depth + 1) for _ in range(count)]


def _single(described: str, rng: np.random.Generator, depth: int) -> Any:
    if described == "boolean":
        return bool(rng.integers(0, 2))
    if described in ("float", "double"):
        values = _FLOATS if described == "float" else _DOUBLES
        return float(rng.choice(values)) if rng.random() < 0.7 else float(rng.uniform(-2.0, 2.0))
    if described in _TYPE_CODES:
        limits = np.iinfo("uint8" if described == "octet" else described)
        number = int(rng.choice([0, 0, 1, 1, 2, 3, 4, 7, 99, 640, 480, limits.min, limits.max]))
        number = min(max(number, int(limits.min)), int(limits.max))
        return bytes([number]) if described == "octet" else number
    if described.startswith(("string", "wstring")):
        bound = re.fullmatch(r"w?string<(\d+)>", described)
        return str(rng.choice(_TEXTS))[: int(bound[1]) if bound else None]
    return hostile_message(message_class(described), rng, depth + 1)
