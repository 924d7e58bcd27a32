"""Messages recorded by another version of our message package, in the shape of today's.

A field that the bag's definition lacks is read off its other fields where those give it, else it gets ROS's default
(0, "", empty); one that today's lacks is left out. A field that changed its type cannot be read, and reports it.
"""

from __future__ import annotations

from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mbd_bag.errors import BagError
from mbd_bag.storage.definitions import full_definition
from mbd_bag.storage.old_messages import DERIVED


@lru_cache(maxsize=64)
def _today(kind: str) -> Any:
    """Type store of the installed definition of a type; raises BagError when it is not installed."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(full_definition(kind), kind))
    return store


def _fields(store: Any, kind: str) -> dict[str, Any]:
    return dict(store.fielddefs[kind][1])


def missing_fields(recorded: Any, kind: str) -> tuple[str, ...]:
    """Fields of today's definition (of the type and all it uses) that a recorded one lacks, ``Type.field``.

    Args:
        recorded: type store of the recorded definition.
        kind: ``package/msg/Type``.
    """
    today = _today(kind)
    lacking = []
    for name in today.fielddefs:
        if name not in recorded.fielddefs:
            continue
        old = _fields(recorded, name)
        missing = [field for field in _fields(today, name) if field not in old and (name, field) not in DERIVED]
        lacking += [f"{name.rpartition('/')[2]}.{field}" for field in missing]
    return tuple(lacking)


def upgrade(value: Any, kind: str, recorded: Any) -> Any:
    """A decoded message with the fields of today's definition.

    Args:
        value: as decoded by the bag's own definition.
        kind: its type.
        recorded: type store of that definition.

    Raises:
        BagError: a field has another type today.
    """
    return _message(value, kind, recorded, _today(kind))


def upgraded_bytes(data: bytes, kind: str, recorded: Any) -> bytes:
    """CDR bytes of a recorded message by today's definition; raises BagError as `upgrade`."""
    value = upgrade(recorded.deserialize_cdr(data, kind), kind, recorded)
    return bytes(_today(kind).serialize_cdr(value, kind))


def _message(value: Any, kind: str, recorded: Any, today: Any) -> Any:
    old = _fields(recorded, kind) if kind in recorded.fielddefs else {}
    made = {}
    for name, description in _fields(today, kind).items():
        if value is None or name not in old:
            made[name] = _default(description, today)
            continue
        if _plain(old[name]) != _plain(description):
            raise BagError(
                f"field '{name}' of '{kind}' was {_plain(old[name])} when the bag was recorded and is "
                f"{_plain(description)} today; read the bag with the version of mbd_msgs it was recorded with"
            )
        made[name] = _field(getattr(value, name), description, recorded, today)
    message = SimpleNamespace(**made)
    for name in made:
        if value is not None and name not in old and (kind, name) in DERIVED:
            setattr(message, name, DERIVED[kind, name](message))
    return message


def _field(value: Any, description: Any, recorded: Any, today: Any) -> Any:
    node, detail = description
    if node == Nodetype.NAME:
        return _message(value, detail, recorded, today)
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) and detail[0][0] == Nodetype.NAME:
        return [_message(v, detail[0][1], recorded, today) for v in value]
    return value


def _plain(description: Any) -> str:
    """A field's type as text."""
    node, detail = description
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return f"{_plain(detail[0])}[]"
    return str(detail[0]) if node == Nodetype.BASE else str(detail)


def _default(description: Any, today: Any) -> Any:
    node, detail = description
    if node == Nodetype.NAME:
        return _message(None, detail, today, today)
    if node in (Nodetype.SEQUENCE, Nodetype.ARRAY):
        count = detail[1] if node == Nodetype.ARRAY else 0
        inner, name = detail[0]
        if inner == Nodetype.BASE and name[0] not in ("string", "wstring"):
            return np.zeros(count, name[0])
        return [_default(detail[0], today) for _ in range(count)]
    return {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}.get(detail[0], 0)
