"""A latched topic that survives the death of its node.

A transient-local sample dies with its writer. Where a node's output is no pure function of latched inputs (a scene was
seen once, a demonstration given once), the node keeps its last message in a file and publishes it when it comes back.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Generic, TypeVar

from rclpy.node import Node
from rclpy.serialization import serialize_message

from mbd_model.errors import MbdError
from mbd_model.folders import set_aside
from mbd_model.ros.kept_messages import kept_message
from mbd_model.ros.qos import LATCHED

Message = TypeVar("Message")


def make_state_folder(folder: Path) -> None:
    """Make a state folder when it is missing; raises MbdError when that cannot be or it cannot be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(f"{folder} is not writable")
    except OSError as error:
        raise MbdError(
            f"state_dir {folder} cannot be used ({error}); give a folder that this user may write"
        ) from error


class LatchedPublisher(Generic[Message]):
    """Publishes on a latched topic and keeps the last message in ``state_dir``.

    Args:
        node: owner of the publisher.
        msg_type: message class of the topic.
        topic: its (relative) name.
        state_dir: folder of this session's state; "" keeps nothing. Made when missing.

    Attributes:
        last: the last message published or restored, None before the first.
    """

    def __init__(self, node: Node, msg_type: type[Message], topic: str, state_dir: str = "") -> None:
        self._node = node
        self._publisher = node.create_publisher(msg_type, topic, LATCHED)
        self._file = Path(state_dir) / (topic.strip("/").replace("/", ".") + ".cdr") if state_dir else None
        self.last: Message | None = None
        if self._file is None:
            return
        make_state_folder(self._file.parent)
        if not self._file.exists():
            return
        try:
            self.last = kept_message(self._file.read_bytes(), msg_type)
        except (RuntimeError, OSError, ValueError, OverflowError, MemoryError) as error:
            # RuntimeError is what rclpy's C layer raises; a broken file must not stop the node.
            aside = set_aside(self._file)
            node.get_logger().error(
                f"{self._file} holds no {msg_type.__name__} ({error}); starting without it. {aside}"
            )
            return
        node.get_logger().info(f"restored {topic} from {self._file}")
        self._publisher.publish(self.last)

    def publish(self, msg: Message) -> None:
        """Keep the message, then publish it: whoever saw it can rely on it being there after a restart."""
        if self._file is not None:
            try:
                self._keep(self._file, serialize_message(msg))
            except OSError as error:
                # The session goes on; only a restart of this node would miss it.
                self._node.get_logger().error(f"{self._file} cannot be kept ({error}): make room, or mend the folder")
        self.last = msg
        self._publisher.publish(msg)

    @staticmethod
    def _keep(file: Path, data: bytes) -> None:
        part = file.with_suffix(".part")
        with part.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(file)

    def forget(self) -> None:
        """Drop the kept message: a new session starts from nothing."""
        self.last = None
        if self._file is not None:
            self._file.unlink(missing_ok=True)
