"""Whether messages of a definition can be read within bounds, decided before any is.

A fixed array of a length in the definition costs its sender nothing and its reader memory: `string[4000000000]`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosbags.interfaces import Nodetype

LONGEST_DEFINITION = 1 << 20  # [characters]; the largest of ROS's own has 50 000
_LARGEST_ARRAY = 1_000_000
_LARGEST_MESSAGE = 128 << 20
_WIDTHS = {"bool": 1, "byte": 1, "char": 1, "octet": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4}
_WIDTHS |= {"uint32": 4, "float32": 4, "int64": 8, "uint64": 8, "float64": 8, "string": 4, "wstring": 4}

# As rosbags reads them: constants and fields by type.
Definitions = Mapping[str, tuple[Any, list[tuple[str, Any]]]]


def least_size(definitions: Definitions, kind: str) -> int:
    """How many bytes a message of a type has at least.

    Args:
        definitions: of the type and all it uses.
        kind: ``package/msg/Type``.

    Raises:
        ValueError: no message of it can be read: it contains itself, a type that is not defined, or too large an array.
    """
    known: dict[str, int] = {}
    _measure(definitions, kind, known, ())
    return known[kind]


def _measure(definitions: Definitions, kind: str, known: dict[str, int], inside: tuple[str, ...]) -> int:
    if kind in known:
        return known[kind]
    if kind in inside:
        raise ValueError(f"type '{kind}' contains itself")
    if len(inside) > 50:
        raise ValueError(f"types are nested deeper than 50 levels, down to '{kind}'")
    if kind not in definitions:
        raise ValueError(f"type '{kind}' is used and not defined")

    def size_of(node: Any) -> int:
        form, detail = node
        if form == Nodetype.BASE:
            return _WIDTHS.get(detail[0], 1)
        if form == Nodetype.NAME:
            return _measure(definitions, detail, known, (*inside, kind))
        element, count = detail
        least = size_of(element)
        if form == Nodetype.SEQUENCE:
            if not least:
                raise ValueError(f"type '{kind}' has a list of elements without content")
            return 4
        if count > _LARGEST_ARRAY:
            raise ValueError(f"type '{kind}' has an array of {count} elements; at most {_LARGEST_ARRAY} are read")
        return max(1, least) * int(count)

    size = sum(size_of(node) for _, node in definitions[kind][1])
    if size > _LARGEST_MESSAGE:
        raise ValueError(f"a message of '{kind}' has at least {size} bytes; at most {_LARGEST_MESSAGE} are read")
    known[kind] = size
    return size
