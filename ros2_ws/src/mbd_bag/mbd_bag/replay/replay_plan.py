"""What of a bag is published again, when some nodes run again: their outputs are left out, their requests asked for."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from mbd_model.session import Phase

from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import COMPRESSED_IMAGE
from mbd_bag.images.image_compression import SUFFIXES
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag

# What each node publishes: last words of topic names.
OUTPUTS = {
    "perception": ("perception/source_scene", "perception/target_scene", "perception/markers"),
    "demonstration": ("demonstration/task", "demonstration/recorded"),
    "mapping": ("mapping/estimate",),
    "interaction": ("interaction/state", "interaction/prompt", "interaction/assists", "interaction/replies"),
    "wizard": tuple(
        f"wizard/{name}"
        for name in (
            *("gripper", "handed", "pointed", "answer", "demonstration", "command", "overwrite", "revision", "note"),
        )
    ),
}
# Published by the graph or by any node about itself: it would be published twice.
NEVER = ("/rosout", "/parameter_events", "/diagnostics")


@dataclass(frozen=True)
class PublishedTopic:
    """A topic of the bag and how it is published.

    Attributes:
        recorded: its name in the bag.
        name: that it is published on; another one when pictures are decompressed.
        msgtype: that is published.
        decompressed: whether pictures are.
    """

    recorded: str
    name: str
    msgtype: str
    decompressed: bool = False


def published_topics(
    bag: Bag, without: Collection[str] = (), *, compressed: bool = False
) -> tuple[PublishedTopic, ...]:
    """The topics to publish.

    Args:
        bag: to replay.
        without: nodes that run again.
        compressed: leave compressed pictures as they are.

    Raises:
        BagError: one of these nodes is not known.
    """
    unknown = sorted(set(without) - set(OUTPUTS))
    if unknown:
        raise BagError(f"no node '{unknown[0]}' is known to replay; expected some of: {', '.join(OUTPUTS)}")
    left_out = tuple(f"/{ending}" for node in without for ending in OUTPUTS[node])
    found = []
    for topic in bag.topics:
        if not topic.count or topic.name in NEVER or topic.name.endswith(left_out):
            continue
        if "/msg/" not in topic.msgtype:
            continue  # events of services and actions: nobody publishes them but their servers
        suffix = next((s for s in SUFFIXES if topic.name.endswith(s)), "")
        if topic.msgtype == COMPRESSED_IMAGE and suffix and not compressed:
            raw = topic.name.removesuffix(suffix)
            found.append(PublishedTopic(topic.name, raw, "sensor_msgs/msg/Image", decompressed=True))
        else:
            found.append(PublishedTopic(topic.name, topic.name, topic.msgtype))
    if not found:
        raise BagError(f"nothing of {bag.path} is left to publish without {', '.join(sorted(without))}")
    return tuple(found)


def phase_times(session: RecordedSession) -> tuple[tuple[Phase, int], ...]:
    """(phase, log time at which it was entered [ns]) in the order entered."""
    found: list[tuple[Phase, int]] = []
    for state in session.states:
        if not found or found[-1][0] is not state.value.phase:
            found.append((state.value.phase, state.log_time))
    return tuple(found)


def phase_start(session: RecordedSession, name: str) -> int:
    """When a phase was first entered [ns of log time]; raises BagError for one that the session never reached."""
    times = phase_times(session)
    for phase, log_time in times:
        if phase.name.lower() == name.lower():
            return log_time
    reached = ", ".join(dict.fromkeys(p.name.lower() for p, _ in times)) or "none"
    raise BagError(f"session '{session.name}' has no phase '{name}'; it reached: {reached}")


def facts_before(bag: Bag, topics: Collection[str], log_time: int) -> dict[str, int]:
    """Of each latched topic the log time of its last message before ``log_time`` [ns]: what a late node still gets."""
    latched = {t for t in topics if any(q.durability == "transient_local" for q in bag.offered_qos(t))}
    return {m.topic: m.log_time for m in bag.messages(latched, end=log_time)}
