"""By which definition the messages of a type can be read, and so which rows are no message of their type."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import zstandard
from mcap.records import Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import LARGEST_RECORD
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.known_definitions import known_definition
from mbd_bag.repairing.sqlite.pages import Pages
from mbd_bag.repairing.sqlite.rows import MessageRow, record_bytes
from mbd_bag.storage.decoding import Decoder

_SAMPLES = 20  # messages that decide on a definition
_PACKED = b"\x28\xb5\x2f\xfd"  # begins what zstd compressed, and no CDR


@dataclass(frozen=True)
class Messages:
    """Reads the data of rows.

    Attributes:
        pages: of their file.
        packed: whether each is compressed by zstd.
    """

    pages: Pages
    packed: bool = False

    def data(self, row: MessageRow) -> bytes | None:
        """The bytes of a message; None when they cannot be had."""
        record = record_bytes(self.pages, row.leaf, row.cell)
        if record is None:
            return None
        return self._unpacked(record[row.offset :]) if self.packed else record[row.offset :]

    def _unpacked(self, data: bytes) -> bytes | None:
        try:
            if zstandard.frame_content_size(data) > LARGEST_RECORD:
                return None
            return zstandard.ZstdDecompressor().decompress(data, max_output_size=LARGEST_RECORD)
        except (zstandard.ZstdError, ValueError):
            return None


def are_packed(pages: Pages, rows: Sequence[MessageRow]) -> bool:
    """Whether most messages of a file are compressed one by one: only metadata.yaml states it."""
    plain = Messages(pages)
    found = [plain.data(row) or b"" for row in _some(rows)]
    return 2 * sum(data.startswith(_PACKED) for data in found) > len(found)


def _some(rows: Sequence[MessageRow]) -> Sequence[MessageRow]:
    return rows[:: max(1, len(rows) // _SAMPLES)][:_SAMPLES]


@dataclass(frozen=True)
class TypeDefinition:
    """How a type is defined.

    Attributes:
        kind: ``package/msg/Type``.
        encoding, text: of its definition; "" when it is not known.
        fits: whether most of its messages can be read by it.
    """

    kind: str
    encoding: str
    text: str
    fits: bool = False

    @property
    def decoder(self) -> Decoder:
        """Reads messages by it."""
        return Decoder([Schema(1, self.text.encode(), self.encoding, self.kind)])


def is_message(decoder: Decoder, kind: str, data: bytes | None) -> bool:
    """Whether bytes are a message of a type.

    Args:
        decoder: knows the type.
        kind: ``package/msg/Type``.
        data: None for none.
    """
    try:
        decoder.decode(BagMessage("", kind, 0, 0, data or b""))
    except BagError:
        return False
    return True


def definition_of(
    kind: str, own: tuple[str, str] | None, messages: Messages, rows: Sequence[MessageRow]
) -> TypeDefinition:
    """The definition of a type: the file's own, or the one known here where that is damaged or missing.

    Args:
        kind: ``package/msg/Type``.
        own: encoding and text by the file; None when it has none.
        messages: reads rows.
        rows: messages of the type.
    """
    offered = [
        TypeDefinition(kind, encoding, text) for encoding, text in (own or ("", ""), known_definition(kind)) if text
    ]
    some = _some(rows)
    for definition in offered:
        decoder = definition.decoder
        fitting = sum(is_message(decoder, kind, messages.data(row)) for row in some)
        if fitting and 2 * fitting >= len(some):
            return TypeDefinition(kind, definition.encoding, definition.text, True)
    return offered[0] if offered else TypeDefinition(kind, "", "")
