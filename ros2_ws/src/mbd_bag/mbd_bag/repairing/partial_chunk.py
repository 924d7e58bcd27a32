"""What a damaged chunk still declares: types and topics whose messages lie in chunks that are intact.

Not its messages: which of them is the damaged one cannot be known. A declaration is taken only when nothing else
declares the same, and it makes sense by itself: a topic's name, a type's name, a text that defines that type.
"""

from __future__ import annotations

import re

import lz4.frame
import zstandard
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg
from rosbags.typesys.store import Typestore

from mbd_bag.formats.chunks import DAMAGE, LARGEST_RECORD, RECORD_HEADER, inner_records, parse
from mbd_bag.formats.definition_limits import least_size

_TOPIC = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_TYPE = re.compile(r"[a-z][a-z0-9_]*/(msg|srv|action)/[A-Z][A-Za-z0-9_]*")
_STEP = 256  # [bytes] fed at once: what comes out before the damage is known to be what went in


def declarations(chunk: Chunk) -> tuple[list[Schema], list[Channel]]:
    """Schemas and channels declared before the damage of a chunk, and perhaps behind it."""
    schemas: list[Schema] = []
    channels: list[Channel] = []
    data = _readable(chunk)
    try:
        for opcode, offset, end in inner_records(data):
            body = data[offset + RECORD_HEADER : end]
            if opcode == Opcode.SCHEMA:
                schemas.append(parse(Schema, body))
            elif opcode == Opcode.CHANNEL:
                channels.append(parse(Channel, body))
    except DAMAGE:
        pass  # the rest cannot be told apart
    return schemas, channels


def names_a_topic(channel: Channel) -> bool:
    """Whether a channel is of a topic by ROS's rules, or of another program's kind."""
    if channel.message_encoding == "cdr":
        return _TOPIC.fullmatch(channel.topic) is not None
    return channel.message_encoding.isascii() and channel.topic.isprintable()


def makes_sense(schema: Schema) -> bool:
    """Whether a schema's text defines the type that its name states; True for one of another kind than ROS's."""
    if schema.encoding not in ("ros2msg", "ros2idl"):
        return schema.encoding.isascii() and schema.name.isprintable()
    if not _TYPE.fullmatch(schema.name):
        return False
    try:
        text = schema.data.decode()
        types = get_types_from_idl(text) if schema.encoding == "ros2idl" else get_types_from_msg(text, schema.name)
        least_size(types, schema.name)
    except (TypesysError, ValueError, KeyError):
        return False
    return True


def definition_hash(schema: Schema) -> str:
    """The REP-2011 hash of a definition that makes sense (``RIHS01_...``); "" where it has none."""
    try:
        text = schema.data.decode()
        types = get_types_from_idl(text) if schema.encoding == "ros2idl" else get_types_from_msg(text, schema.name)
        store = Typestore()
        store.register(types)
        return store.hash_rihs01(schema.name)
    except (TypesysError, ValueError, KeyError, TypeError):
        return ""


def _readable(chunk: Chunk) -> bytes:
    """The decompressed bytes of a chunk up to where that fails."""
    if chunk.compression == "":
        return chunk.data
    made = bytearray()
    lz4_frame, zstd_frame = lz4.frame.LZ4FrameDecompressor(), zstandard.ZstdDecompressor().decompressobj()
    frame = lz4_frame if chunk.compression == "lz4" else zstd_frame
    try:
        for start in range(0, len(chunk.data), _STEP):
            made += frame.decompress(chunk.data[start : start + _STEP])
            if len(made) > LARGEST_RECORD:
                break
    except (*DAMAGE, EOFError):
        pass
    return bytes(made)
