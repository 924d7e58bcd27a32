"""Messages from their bytes, by the definitions a bag embeds: no ROS, and no package of the time of recording."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from mbd_model.times import to_seconds
from mcap.records import Schema
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

from mbd_bag.errors import BagError
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.definition_limits import LONGEST_DEFINITION, least_size

_ENCODINGS = ("ros2msg", "ros2idl")


def full_name(kind: str) -> str:
    """A type's name as it is since Dashing, ``package/msg/Type``; earlier bags leave the middle out."""
    return kind.replace("/", "/msg/") if kind.count("/") == 1 else kind


@lru_cache(maxsize=256)
def _store_of(kind: str, text: str, encoding: str) -> tuple[Any, int]:
    """A type store that knows one type by its definition, and the least size of its messages [byte].

    Kept, since bags of one study share their definitions.

    Raises:
        TypesysError: the text is no definition.
        ValueError: no message of it could be read.
    """
    if len(text) > LONGEST_DEFINITION:
        raise ValueError(f"its {len(text)} characters are more than the {LONGEST_DEFINITION} expected at most")
    types = get_types_from_msg(text, kind) if encoding == "ros2msg" else get_types_from_idl(text)
    kind = full_name(kind)
    least = least_size(types, kind)
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store, least


def _brief(error: Exception) -> str:
    """An error in one line; some of rosbags' quote all of a definition."""
    text = " ".join(str(error).split())
    return text if len(text) <= 200 else f"{text[:200]}..."


class Decoder:
    """Turns a bag's messages into objects with the fields of their definitions as attributes.

    Args:
        schemas: of all files of the bag.

    Attributes:
        texts: definition by type.

    Raises:
        BagError: two files define one type differently, or a definition is no text.
    """

    def __init__(self, schemas: Iterable[Schema]) -> None:
        self.texts: dict[str, str] = {}
        self._encodings: dict[str, str] = {}
        for schema in schemas:
            if schema.encoding not in _ENCODINGS:
                continue
            try:
                text = schema.data.decode()
            except UnicodeDecodeError as error:
                raise BagError(
                    f"the bag's definition of '{schema.name}' is no text ({error.reason}): it is damaged"
                ) from error
            self._encodings[schema.name] = schema.encoding
            if self.texts.setdefault(schema.name, text) != text:
                raise BagError(
                    f"the bag's files define '{schema.name}' differently: recorded with different versions of its "
                    f"package; read the files one by one"
                )

    def store(self, kind: str) -> Any:
        """The type store of one type; raises BagError when the bag does not define it."""
        return self._known(kind)[0]

    def _known(self, kind: str) -> tuple[Any, int]:
        if kind not in self.texts:
            raise BagError(f"the bag embeds no definition of '{kind}'; expected one as `recorder` writes it")
        try:
            return _store_of(kind, self.texts[kind], self._encodings[kind])
        except (TypesysError, KeyError, ValueError, RecursionError, SyntaxError) as error:
            raise BagError(
                f"the bag's definition of '{kind}' cannot be read ({_brief(error)}): it is damaged"
            ) from error

    def decode(self, message: BagMessage) -> Any:
        """The message as an object; raises BagError when its definition or its bytes are not what they should be."""
        store, least = self._known(message.msgtype)
        try:
            if len(message.data) < least:
                raise SerdeError(f"its {len(message.data)} bytes are fewer than the {least} expected at least")
            return store.deserialize_cdr(message.data, full_name(message.msgtype))
        except (SerdeError, KeyError, ValueError, IndexError, struct.error, OverflowError, AssertionError) as error:
            raise BagError(
                f"topic {message.topic}: a message of {to_seconds(message.log_time):.3f} s is no '{message.msgtype}' "
                f"({_brief(error)})"
            ) from error

    def encode(self, message: Any, msgtype: str) -> bytes:
        """The CDR bytes of an object got from `decode`."""
        return bytes(self.store(msgtype).serialize_cdr(message, full_name(msgtype)))
