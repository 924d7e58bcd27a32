"""A recorded session from its bag (decoded by the bag's own definitions), and into one."""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from mbd_model.camera.view import CameraView
from mbd_model.errors import MbdError
from mbd_model.ros import conversions
from mbd_model.times import to_seconds
from mbd_msgs import msg as m
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from mbd_bag.errors import BagError
from mbd_bag.session.recorded_session import (
    Recorded,
    RecordedReply,
    RecordedSession,
    TrueObject,
    Truth,
)
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition
from mbd_bag.storage.message_writer import EVENTS, LATCHED, SENSOR, MessageWriter
from mbd_bag.storage.upgrading import missing_fields, upgrade

# Of which topic (its last words, so that a namespace does not matter) each list of a session is made.
TOPICS = {
    "source_scenes": ("perception/source_scene", "mbd_msgs/msg/Scene"),
    "target_scenes": ("perception/target_scene", "mbd_msgs/msg/Scene"),
    "tasks": ("demonstration/task", "mbd_msgs/msg/Task"),
    "assists": ("interaction/assists", "mbd_msgs/msg/Assists"),
    "estimates": ("mapping/estimate", "mbd_msgs/msg/MappingEstimate"),
    "prompts": ("interaction/prompt", "mbd_msgs/msg/Prompt"),
    "states": ("interaction/state", "mbd_msgs/msg/SessionState"),
    "replies": ("interaction/replies", "mbd_msgs/msg/WizardReply"),
    "notes": ("wizard/note", "mbd_msgs/msg/WizardNote"),
    "truths": ("cell/truth", "mbd_msgs/msg/CellTruth"),
}


def truth_from_msg(msg: Any) -> Truth:
    """What the simulated cell knows of its table; raises MbdError for a role that is none."""
    return Truth(
        task=msg.task,
        role=conversions.role_from_code(msg.role),
        seed=int(msg.seed),
        objects=tuple(
            TrueObject(
                name=o.name,
                centroid=(float(o.pose.position.x), float(o.pose.position.y), float(o.pose.position.z)),
                size=(float(o.size.y), float(o.size.x), float(o.size.z)),
                hue=float(o.hue) if o.has_hue else None,
            )
            for o in msg.objects
        ),
        solution={s.source_name: frozenset(s.target_names) for s in msg.solution},
    )


VALUES: dict[str, Callable[[Any], Any]] = {
    "source_scenes": conversions.scene_from_msg,
    "target_scenes": conversions.scene_from_msg,
    "tasks": conversions.task_from_msg,
    "assists": conversions.assists_from_msg,
    "estimates": conversions.estimate_from_msg,
    "prompts": conversions.prompt_from_msg,
    "states": conversions.state_from_msg,
    "replies": lambda msg: RecordedReply(msg.topic, bool(msg.accepted), msg.reason),
    "notes": lambda msg: str(msg.text),
    "truths": truth_from_msg,
}


def _topic_names(bag: Bag) -> dict[str, str]:
    """Which list of a session each of the bag's topics makes; raises BagError when two topics make one list."""
    names: dict[str, str] = {}
    for key, (suffix, msgtype) in TOPICS.items():
        found = [t for t in bag.topics if f"/{t.name}".endswith(f"/{suffix}") and t.count]
        wrong = [t for t in found if t.msgtype != msgtype]
        if wrong:
            raise BagError(f"topic {wrong[0].name} of {bag.path} is '{wrong[0].msgtype}'; expected '{msgtype}'")
        if len(found) > 1:
            raise BagError(f"{bag.path} holds several sessions: topics {[t.name for t in found]}; expected one of them")
        names |= {t.name: key for t in found}
    return names


def session_from_bag(bag: Bag) -> RecordedSession:
    """Everything a session's topics hold.

    Raises:
        BagError: the bag has none of a session's topics, or a message cannot be what this version expects.
    """
    names = _topic_names(bag)
    if not names and "session" not in bag.facts:
        raise BagError(
            f"{bag.path} is a ROS 2 bag, but of another program: it has none of a session's topics "
            f"(expected e.g. {', '.join(suffix for suffix, _ in list(TOPICS.values())[1:5])})"
        )
    lists: dict[str, list[Any]] = {key: [] for key in (*TOPICS, "denials")}
    kinds = {key: TOPICS[key][1] for key in names.values()}
    lacking = {kind: missing_fields(bag.decoder.store(kind), kind) for kind in set(kinds.values())}
    skewed = {kind: bag.decoder.texts[kind].strip() != full_definition(kind).strip() for kind in lacking}
    for message, decoded in bag.decoded(set(names)):
        key = names[message.topic]
        kind = kinds[key]
        try:
            msg = upgrade(decoded, kind, bag.decoder.store(kind)) if skewed[kind] else decoded
            stamp = conversions.stamp_from_msg(msg.header.stamp)
            recorded: Any = Recorded(VALUES[key](msg), stamp, message.log_time)
            if key == "estimates":
                recorded = (recorded, conversions.inputs_from_msg(msg))
            elif key == "assists":
                lists["denials"].append(replace(recorded, value=conversions.denials_from_msg(msg)))
        except AttributeError as error:
            raise BagError(f"topic {message.topic} was recorded with another version of mbd_msgs: {error}") from error
        except (MbdError, ValueError) as error:
            raise BagError(f"topic {message.topic} at {to_seconds(message.log_time):.3f} s: {error}") from error
        lists[key].append(recorded)
    if not any(d.value for d in lists["denials"]):
        lists["denials"] = []
    state_names = [s.value.session for s in lists["states"]]
    name = bag.facts.get("session") or (state_names[-1] if state_names else "") or bag.path.name
    old = sorted({field for fields in lacking.values() for field in fields})
    skew = (f"recorded by an older version of mbd_msgs without {', '.join(old)}: read as 0 or empty",) if old else ()
    return RecordedSession(
        name=name,
        facts=bag.facts,
        problems=bag.problems + skew,
        **{key: tuple(values) for key, values in lists.items()},
    )


def truth_to_msg(value: Truth) -> m.CellTruth:
    """What the simulated cell knows of its table."""
    return m.CellTruth(
        task=value.task,
        role=conversions.ROLE_TO_CODE[value.role],
        seed=value.seed,
        objects=[
            m.ObjectTruth(
                name=o.name,
                pose=Pose(position=Point(x=o.centroid[0], y=o.centroid[1], z=o.centroid[2])),
                size=Vector3(x=o.size[1], y=o.size[0], z=o.size[2]),
                has_hue=o.hue is not None,
                hue=math.nan if o.hue is None else o.hue,
            )
            for o in value.objects
        ],
        solution=[
            m.AcceptableTargets(source_name=source, target_names=sorted(targets))
            for source, targets in value.solution.items()
        ],
    )


def _messages(session: RecordedSession) -> dict[str, list[tuple[Any, int, int]]]:
    """(message, its own stamp, log time) of everything, by the list it is in."""
    seconds = 1e-9
    to_msg: dict[str, Callable[[Recorded[Any]], Any]] = {
        "source_scenes": lambda r: conversions.scene_to_msg(r.value),
        "target_scenes": lambda r: conversions.scene_to_msg(r.value),
        "tasks": lambda r: conversions.task_to_msg(r.value),
        "prompts": lambda r: conversions.prompt_to_msg(r.value, r.stamp * seconds),
        "states": lambda r: conversions.state_to_msg(r.value, r.stamp * seconds),
        "replies": lambda r: m.WizardReply(topic=r.value.topic, accepted=r.value.accepted, reason=r.value.reason),
        "notes": lambda r: m.WizardNote(text=r.value),
        "truths": lambda r: truth_to_msg(r.value),
    }
    messages = {key: [(make(r), r.stamp, r.log_time) for r in getattr(session, key)] for key, make in to_msg.items()}
    # A session of another source than a bag need not list denials.
    denials = (*(d.value for d in session.denials), *((),) * (len(session.assists) - len(session.denials)))
    messages["assists"] = [
        (conversions.assists_to_msg(r.value, r.stamp * seconds, session.name, denied), r.stamp, r.log_time)
        for r, denied in zip(session.assists, denials, strict=True)
    ]
    messages["estimates"] = [
        (
            conversions.estimate_to_msg(
                r.value,
                session=session.name,
                threshold=inputs.threshold,
                stamps=(
                    conversions.stamp_to_msg(inputs.task_stamp),
                    conversions.stamp_to_msg(inputs.scene_stamp),
                    conversions.stamp_to_msg(inputs.assists_stamp),
                ),
            ),
            r.stamp,
            r.log_time,
        )
        for r, inputs in session.estimates
    ]
    return messages


def session_to_bag(
    session: RecordedSession,
    bag: BagWriter,
    pictures: Sequence[Recorded[NDArray[np.uint8]]] = (),
    camera: CameraView | None = None,
) -> None:
    """Write a session as a recorder would have, in order of log time; the caller closes the bag.

    Args:
        session: to write.
        bag: new.
        pictures: colour pictures, (height, width, 3) RGB.
        camera: that took them; None: no camera_info.
    """
    writer = MessageWriter(bag)
    bag.add_facts(session.facts)
    rows: list[tuple[int, str, Any, Any]] = []
    for key, messages in _messages(session).items():
        qos = EVENTS if key in {"replies", "notes"} else LATCHED
        for message, stamp, log_time in messages:
            message.header.stamp = conversions.stamp_to_msg(stamp)
            rows.append((log_time, f"/{TOPICS[key][0]}", message, qos))
    for shown in pictures:
        header = Header(stamp=conversions.stamp_to_msg(shown.stamp), frame_id="camera_color_optical_frame")
        height, width = shown.value.shape[:2]
        image = Image(header=header, width=width, height=height, encoding="rgb8", step=3 * width)
        image.data = array.array("B", np.ascontiguousarray(shown.value).tobytes())
        rows.append((shown.log_time, "/camera/color/image_raw", image, SENSOR))
        if camera is not None:
            fx, fy, cx, cy = camera.intrinsics
            info = CameraInfo(header=header, width=camera.size[0], height=camera.size[1])
            info.k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
            rows.append((shown.log_time, "/camera/color/camera_info", info, SENSOR))
    for log_time, topic, message, qos in sorted(rows, key=lambda row: row[0]):
        writer.write(topic, message, log_time, qos)
