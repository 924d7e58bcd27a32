"""Quality of service of a topic: as rosbag2 writes it down, and as a recorder must ask for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import yaml

from mbd_bag.formats.bounded_yaml import bounded_yaml

# rosbag2 writes an unlimited duration as the largest one.
_INFINITE = {"sec": 9223372036, "nsec": 854775807}
LARGEST_DEPTH = 100_000  # a publisher keeps so many at most, whatever a bag asks for
# Before Iron it wrote rmw's numbers.
_RELIABILITY = {"1": "reliable", "2": "best_effort"}
_DURABILITY = {"1": "transient_local", "2": "volatile"}
_HISTORY = {"1": "keep_last", "2": "keep_all"}


@dataclass(frozen=True)
class TopicQos:
    """The part of a QoS profile that decides what is received; names as rosbag2 spells them.

    Attributes:
        reliability: "reliable" or "best_effort".
        durability: "transient_local" or "volatile".
        history: "keep_last" or "keep_all"; "unknown" when the publisher was on the network, which does not report it.
        depth: messages kept with "keep_last".
    """

    reliability: str = "reliable"
    durability: str = "volatile"
    history: str = "keep_last"
    depth: int = 10

    def as_rosbag2(self) -> dict[str, object]:
        """The mapping that metadata.yaml version 9 has for it."""
        return {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": dict(_INFINITE),
            "lifespan": dict(_INFINITE),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(_INFINITE),
            "avoid_ros_namespace_conventions": False,
        }


def as_yaml(profiles: Sequence[TopicQos]) -> str:
    """The text of a channel's ``offered_qos_profiles``."""
    return yaml.safe_dump([p.as_rosbag2() for p in profiles], sort_keys=False)


def wanted_qos(publishers: Sequence[TopicQos], subscribers: Sequence[TopicQos], depth: int = 1000) -> TopicQos:
    """The strongest profile that every publisher can serve.

    Reliable (or transient local) only if all publishers are: a stronger request would match none of the weaker ones.
    Nobody publishes yet: what those who listen expect, so that the first message of a topic is not missed.

    Args:
        publishers: profiles offered on the topic.
        subscribers: profiles asked for on the topic.
        depth: messages to keep while the recorder is busy elsewhere.
    """
    known = publishers or subscribers
    reliable = all(p.reliability == "reliable" for p in known)
    latched = reliable and bool(known) and all(p.durability == "transient_local" for p in known)
    return TopicQos(
        reliability="reliable" if reliable else "best_effort",
        durability="transient_local" if latched else "volatile",
        depth=depth,
    )


def from_yaml(text: str) -> tuple[TopicQos, ...]:
    """The profiles of a channel's ``offered_qos_profiles``; () when it states none that we know."""
    try:
        entries = bounded_yaml(text) or []
        return tuple(
            TopicQos(
                _named(e["reliability"], _RELIABILITY, "reliable"),
                _named(e["durability"], _DURABILITY, "volatile"),
                _named(e["history"], _HISTORY, "unknown"),
                min(max(0, int(e["depth"])), LARGEST_DEPTH),
            )
            for e in entries
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        return ()


def _named(stated: object, names: dict[str, str], otherwise: str) -> str:
    """The name of a policy; ``otherwise`` for one that states nothing (system_default, unknown) or is none."""
    text = names.get(str(stated), str(stated))
    return text if text in names.values() else otherwise
