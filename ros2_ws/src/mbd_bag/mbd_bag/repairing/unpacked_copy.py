"""A file with its chunks uncompressed, for trials that change single records."""

from __future__ import annotations

from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter


def rewrite_uncompressed(path: Path) -> None:
    """Write an intact MCAP file again without compression, in its place."""
    with path.open("rb") as stream:
        messages = list(make_reader(stream).iter_messages())
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE)
        writer.start(profile="ros2", library="trial")
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in messages:
            if schema is not None and schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                number = schemas.get(channel.schema_id, 0)
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", number, channel.metadata)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
