"""Messages kept in a state folder, also by a version whose definitions lacked fields that were added since.

A file holds a message's CDR bytes and nothing of its definition. They are read strictly, as each version in turn laid
them out, the present one first: a layout fits only when it uses up every byte and every text and truth value is one.
"""

from __future__ import annotations

import re
import struct
from importlib import import_module
from typing import Any, TypeVar

Message = TypeVar("Message")

Field = tuple[str, str]  # name of the message type, name of the field

# Fields that versions before did not have, by the version that added them, the latest first.
ADDED: dict[str, frozenset[Field]] = {
    "0.3.0": frozenset(
        {
            ("Assist", "confirmed"),
            ("Assists", "denials"),
            ("SessionState", "denials"),
            ("SessionState", "skipped"),
            ("SessionState", "words"),
            ("Prompt", "target_ids"),
            ("Prompt", "source_ids"),
            ("Task", "doubts"),
        }
    ),
    "0.2.0": frozenset(
        {
            ("SessionState", "recording"),
            ("SessionState", "awaiting"),
            ("Progress", "purpose"),
            ("Progress", "object_id"),
            ("Progress", "receiver_id"),
            ("Task", "open_ends"),
        }
    ),
}
HEADER = b"\x00\x01\x00\x00"  # plain CDR, little endian
NUMBERS = {
    "octet": "B", "uint8": "B", "int8": "b", "uint16": "H", "int16": "h", "uint32": "I", "int32": "i", "uint64": "Q",
    "int64": "q", "float": "f", "double": "d",
}  # fmt: skip
LIST = re.compile(r"sequence<(?P<each>.+)>|(?P<of>.+)\[(?P<count>\d+)\]")


class _NotSoError(Exception):
    """The bytes are not laid out so."""


def kept_message(data: bytes, msg_type: type[Message]) -> Message:
    """The message a file holds; fields that the version which kept it did not have get ROS's defaults.

    Args:
        data: CDR bytes, with their header.
        msg_type: message class.

    Raises:
        RuntimeError: no such message; as what rclpy's C layer raises.
    """
    lacking: frozenset[Field] = frozenset()
    for added in (frozenset[Field](), *ADDED.values()):
        lacking |= added
        reader = _CdrReader(data, lacking)
        try:
            message = reader.message(msg_type)
        except _NotSoError:
            continue
        if reader.place == len(data):
            return message
    raise RuntimeError(f"{len(data)} bytes are no {msg_type.__name__} of this or an earlier version")


class _CdrReader:
    """Reads CDR bytes field by field, leaving out those that are lacking."""

    def __init__(self, data: bytes, lacking: frozenset[Field]) -> None:
        self._data, self._lacking = data, lacking
        self.place = len(HEADER)
        self._wrong_header = data[: len(HEADER)] != HEADER

    def message(self, msg_type: type[Message]) -> Message:
        """One message, from here on."""
        if self._wrong_header:
            raise _NotSoError
        made = msg_type()
        fields: dict[str, str] = msg_type.get_fields_and_field_types()  # type: ignore[attr-defined]
        for name, kind in fields.items():
            if (msg_type.__name__, name) not in self._lacking:
                setattr(made, name, self._value(kind))
        return made

    def _value(self, kind: str) -> Any:
        if kind in NUMBERS:
            return self._number(NUMBERS[kind])
        if kind == "boolean":
            value = self._number("B")
            if value > 1:
                raise _NotSoError
            return bool(value)
        if kind == "string":
            return self._text()
        found = LIST.fullmatch(kind)
        if found is None:
            package, _, name = kind.partition("/")
            return self.message(getattr(import_module(f"{package}.msg"), name))
        if found["count"]:
            return [self._value(found["of"]) for _ in range(int(found["count"]))]
        count = self._number("I")
        if count > len(self._data):
            raise _NotSoError
        return [self._value(found["each"]) for _ in range(count)]

    def _number(self, code: str) -> Any:
        size = struct.calcsize(code)
        start = self.place + -(self.place - len(HEADER)) % size
        if start + size > len(self._data):
            raise _NotSoError
        self.place = start + size
        return struct.unpack_from("<" + code, self._data, start)[0]

    def _text(self) -> str:
        size = self._number("I")
        raw = self._data[self.place : self.place + size]
        self.place += size
        if not size or len(raw) < size or raw[-1]:
            raise _NotSoError
        try:
            return raw[:-1].decode()
        except UnicodeDecodeError as error:
            raise _NotSoError from error
