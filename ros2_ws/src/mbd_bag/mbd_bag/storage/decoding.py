"""Messages from their bytes, by the definitions a bag embeds: no ROS, and no package of the time of recording."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from mbd_model.times import to_seconds
from mcap.records import Schema
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from mbd_bag.errors import BagError
from mbd_bag.storage.mcap_file import BagMessage


@lru_cache(maxsize=256)
def _store_of(kind: str, text: str) -> Any:
    """A type store that knows one type by its definition; kept, since bags of one study share their definitions.

    Raises:
        TypesysError: the text is no definition.
    """
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, kind))
    return store


class Decoder:
    """Turns a bag's messages into objects with the fields of their definitions as attributes.

    Args:
        schemas: of all files of the bag.

    Attributes:
        texts: definition by type.

    Raises:
        BagError: two files define one type differently.
    """

    def __init__(self, schemas: Iterable[Schema]) -> None:
        self.texts: dict[str, str] = {}
        for schema in schemas:
            if schema.encoding != "ros2msg":
                continue
            text = schema.data.decode()
            if self.texts.setdefault(schema.name, text) != text:
                raise BagError(
                    f"the bag's files define '{schema.name}' differently: recorded with different versions of its "
                    f"package; read the files one by one"
                )

    def store(self, kind: str) -> Any:
        """The type store of one type; raises BagError when the bag does not define it."""
        if kind not in self.texts:
            raise BagError(f"the bag embeds no definition of '{kind}'; expected one as `recorder` writes it")
        try:
            return _store_of(kind, self.texts[kind])
        except (TypesysError, KeyError) as error:
            raise BagError(f"the bag's definition of '{kind}' cannot be read ({error}): it is damaged") from error

    def decode(self, message: BagMessage) -> Any:
        """The message as an object; raises BagError when its definition or its bytes are not what they should be."""
        try:
            return self.store(message.msgtype).deserialize_cdr(message.data, message.msgtype)
        except (SerdeError, KeyError) as error:
            raise BagError(
                f"topic {message.topic}: a message of {to_seconds(message.log_time):.3f} s is no '{message.msgtype}' "
                f"({error})"
            ) from error

    def encode(self, message: Any, msgtype: str) -> bytes:
        """The CDR bytes of an object got from `decode`."""
        return bytes(self.store(msgtype).serialize_cdr(message, msgtype))
