"""Messages from their bytes, by the definitions a bag embeds: no ROS, and no package of the time of recording."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from mcap.records import Schema
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from mbd_study.errors import BagError
from mbd_study.mcap_file import BagMessage


class Decoder:
    """Turns a bag's messages into objects with the fields of their definitions as attributes.

    Args:
        schemas: of all files of the bag.

    Raises:
        BagError: two files define one type differently.
    """

    def __init__(self, schemas: Iterable[Schema]) -> None:
        self._texts: dict[str, str] = {}
        self._store = get_typestore(Stores.EMPTY)
        self._registered: set[str] = set()
        for schema in schemas:
            if schema.encoding != "ros2msg":
                continue
            text = schema.data.decode()
            if self._texts.setdefault(schema.name, text) != text:
                raise BagError(
                    f"the bag's files define '{schema.name}' differently: recorded with different versions of its "
                    f"package; read the files one by one"
                )

    def decode(self, message: BagMessage) -> Any:
        """The message as an object; raises BagError when its definition or its bytes are not what they should be."""
        kind = message.msgtype
        try:
            if kind not in self._registered:
                if kind not in self._texts:
                    raise BagError(
                        f"topic {message.topic}: the bag embeds no definition of '{kind}'; expected one as `recorder` "
                        f"writes it"
                    )
                self._store.register(get_types_from_msg(self._texts[kind], kind))
                self._registered.add(kind)
            return self._store.deserialize_cdr(message.data, kind)
        except (SerdeError, TypesysError, KeyError) as error:
            raise BagError(
                f"topic {message.topic}: a message of {message.log_time / 1e9:.3f} s is no '{kind}' ({error})"
            ) from error

    def encode(self, message: Any, msgtype: str) -> bytes:
        """The CDR bytes of an object got from `decode`."""
        return bytes(self._store.serialize_cdr(message, msgtype))
