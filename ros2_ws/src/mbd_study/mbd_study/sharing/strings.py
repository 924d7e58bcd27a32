"""What becomes of each text in a message: kept, kept when it is an object's id, replaced, or emptied.

A text that stands in no list here is emptied: a new field is left out until somebody has looked at it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import fields, is_dataclass
from enum import Enum, auto
from typing import Any

from mbd_study.sharing.names import NameFinder


class TextRule(Enum):
    """What is done with a field's texts."""

    WORDS = auto()  # of the set-up or made by the robot: kept, without names
    OBJECT = auto()  # id of an object: kept when perception gave it, as an operator may type anything
    SESSION = auto()  # name of the session: the new one
    EMPTIED = auto()  # a person's words may stand there


_WORDS: Mapping[str, tuple[str, ...]] = {
    "std_msgs/msg/Header": ("frame_id",),
    "sensor_msgs/msg/JointState": ("name",),
    "sensor_msgs/msg/CameraInfo": ("distortion_model",),
    "sensor_msgs/msg/Image": ("encoding",),
    "sensor_msgs/msg/CompressedImage": ("format",),
    "sensor_msgs/msg/PointField": ("name",),
    "geometry_msgs/msg/TransformStamped": ("child_frame_id",),
    "mbd_msgs/msg/AcceptableTargets": ("source_name", "target_names"),
    "mbd_msgs/msg/CellTruth": ("task",),
    "mbd_msgs/msg/MappingEstimate": ("strategy", "winning", "runner_up", "warnings"),
    "mbd_msgs/msg/ObjectFeatures": ("color_name", "object_class", "affordances", "properties"),
    "mbd_msgs/msg/ObjectTruth": ("name",),
    "mbd_msgs/msg/Prompt": ("text",),
    "mbd_msgs/msg/Task": ("problems",),
    "mbd_msgs/msg/WizardReply": ("topic",),
}
_OBJECTS: Mapping[str, tuple[str, ...]] = {
    "mbd_msgs/msg/Assist": ("source_id", "target_id"),
    "mbd_msgs/msg/Correspondence": ("source_id", "target_id"),
    "mbd_msgs/msg/Denial": ("source_id", "target_id"),
    "mbd_msgs/msg/MappingEstimate": ("next_question", "question_targets"),
    "mbd_msgs/msg/ObjectFeatures": ("id",),
    "mbd_msgs/msg/Progress": ("object_id", "receiver_id"),
    "mbd_msgs/msg/Prompt": ("source_id", "target_ids", "source_ids"),
    "mbd_msgs/msg/SpatialRelation": ("other_id",),
    "mbd_msgs/msg/TaskStep": ("primary_object", "runner_up"),
    "mbd_msgs/msg/WizardHanded": ("object_id",),
    "mbd_msgs/msg/WizardOverwrite": ("object_id",),
    "mbd_msgs/msg/WizardPointed": ("object_id",),
    "mbd_msgs/msg/WizardRevision": ("object",),
}
_SESSIONS = tuple(f"mbd_msgs/msg/{kind}" for kind in ("Assists", "MappingEstimate", "Progress", "SessionState"))
_EMPTIED: Mapping[str, tuple[str, ...]] = {
    "mbd_msgs/msg/Progress": ("text",),
    "mbd_msgs/msg/SessionState": ("detail",),
    "mbd_msgs/msg/Stop": ("reason",),
    "mbd_msgs/msg/WizardReply": ("reason",),
}
RULES: Mapping[tuple[str, str], TextRule] = {
    **{(kind, name): TextRule.WORDS for kind, names in _WORDS.items() for name in names},
    **{(kind, name): TextRule.OBJECT for kind, names in _OBJECTS.items() for name in names},
    **{(kind, "session"): TextRule.SESSION for kind in _SESSIONS},
    **{(kind, name): TextRule.EMPTIED for kind, names in _EMPTIED.items() for name in names},
}


def parts_of(message: Any) -> Iterator[Any]:
    """A decoded message and every message within it."""
    if is_dataclass(message):
        yield message
        for field in fields(message):
            yield from parts_of(getattr(message, field.name))
    elif isinstance(message, list | tuple):
        for one in message:
            if is_dataclass(one):
                yield from parts_of(one)


def clean_message(
    message: Any,
    *,
    session: str,
    ids: frozenset[str],
    names: NameFinder,
    changed: MutableMapping[str, int],
) -> None:
    """Take a person's words and names out of a decoded message, and count what was changed.

    Args:
        message: as decoded; changed in place.
        session: the new name of its session.
        ids: of the objects that perception saw.
        names: that must not be read.
        changed: number of texts, by ``Type.field``.
    """
    for part in parts_of(message):
        kind = str(getattr(part, "__msgtype__", type(part).__name__))
        # rosbags keeps the type's name in a field, too.
        for field in (f for f in fields(part) if not f.name.startswith("__")):
            value = getattr(part, field.name)
            many = isinstance(value, list)
            texts = value if many else [value]
            if not texts or not all(isinstance(text, str) for text in texts):
                continue
            rule = RULES.get((kind, field.name), TextRule.EMPTIED)
            new = [_cleaned(text, rule, session, ids, names) for text in texts]
            if new != texts:
                setattr(part, field.name, new if many else new[0])
                if rule is not TextRule.SESSION:
                    key = f"{kind.rpartition('/')[2]}.{field.name}"
                    changed[key] = changed.get(key, 0) + sum(a != b for a, b in zip(texts, new, strict=True))


def _cleaned(text: str, rule: TextRule, session: str, ids: frozenset[str], names: NameFinder) -> str:
    if rule is TextRule.SESSION:
        return session if text else ""
    if rule is TextRule.EMPTIED:
        return ""
    if rule is TextRule.OBJECT:
        return text if text in ids else ""
    return names.without(text)
