"""What of a bag is replayed, and how."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_bag.replay.replay_plan import PublishedTopic


@dataclass(frozen=True)
class ReplayOptions:
    """What to publish and how.

    Attributes:
        topics: of the bag.
        begin: log time to start at [ns].
        rate: recorded seconds a second.
        loop: start over at the end.
        paused: begin paused.
        without: nodes that run again; they are waited for, and asked for what interaction asked them then.
    """

    topics: tuple[PublishedTopic, ...]
    begin: int
    rate: float = 1.0
    loop: bool = False
    paused: bool = False
    without: tuple[str, ...] = ()
