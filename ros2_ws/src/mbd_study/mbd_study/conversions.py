"""A recorded session from its bag: the messages, decoded by the bag's own definitions, as values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbd_model import conversions
from mbd_model.errors import MbdError

from mbd_study.bag import Bag
from mbd_study.errors import BagError
from mbd_study.recorded_session import (
    EstimateInputs,
    Recorded,
    RecordedSession,
    Reply,
    TrueObject,
    Truth,
)

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


def nanoseconds(stamp: Any) -> int:
    """A builtin_interfaces/Time [ns]."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


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


def inputs_from_msg(msg: Any) -> EstimateInputs:
    """Which inputs a MappingEstimate came from."""
    return EstimateInputs(
        task_stamp=nanoseconds(msg.task_stamp),
        scene_stamp=nanoseconds(msg.scene_stamp),
        assists_stamp=nanoseconds(msg.assists_stamp),
        threshold=float(msg.threshold),
        confident=bool(msg.confident),
    )


VALUES: dict[str, Callable[[Any], Any]] = {
    "source_scenes": conversions.scene_from_msg,
    "target_scenes": conversions.scene_from_msg,
    "tasks": conversions.task_from_msg,
    "assists": conversions.assists_from_msg,
    "estimates": conversions.estimate_from_msg,
    "prompts": conversions.prompt_from_msg,
    "states": conversions.state_from_msg,
    "replies": lambda msg: Reply(msg.topic, bool(msg.accepted), msg.reason),
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
    """Everything a session's topics say.

    Raises:
        BagError: the bag has none of a session's topics, or a message cannot be what this version expects.
    """
    names = _topic_names(bag)
    if not names:
        raise BagError(
            f"{bag.path} is a ROS 2 bag, but of another program: it has none of a session's topics "
            f"(expected e.g. {', '.join(suffix for suffix, _ in list(TOPICS.values())[1:5])})"
        )
    lists: dict[str, list[Any]] = {key: [] for key in TOPICS}
    for message, msg in bag.decoded(set(names)):
        key = names[message.topic]
        try:
            stamp = nanoseconds(msg.header.stamp)
            recorded: Any = Recorded(VALUES[key](msg), stamp, message.log_time)
            if key == "estimates":
                recorded = (recorded, inputs_from_msg(msg))
        except AttributeError as error:
            raise BagError(f"topic {message.topic} was recorded with another version of mbd_msgs: {error}") from error
        except (MbdError, ValueError) as error:
            raise BagError(f"topic {message.topic} at {message.log_time / 1e9:.3f} s: {error}") from error
        lists[key].append(recorded)
    state_names = [s.value.session for s in lists["states"]]
    name = bag.facts.get("session") or (state_names[-1] if state_names else "") or bag.path.name
    return RecordedSession(
        name=name, facts=bag.facts, problems=bag.problems, **{key: tuple(values) for key, values in lists.items()}
    )
